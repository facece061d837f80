//! The lamps of a scene. A lamp is a point, or a rectangle that is sampled at points. Tracer, stream and reference
//! renderer know only the points, each as a separate light.

use glam::{DVec3, Vec3};

use super::light::Light;
use super::light::MAX_LIGHTS;
use crate::quantity::LightId;

/// The lamp of each light. Lights of a lamp follow one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lamps {
    of: [u8; MAX_LIGHTS],
    count: u8,
}

impl Lamps {
    /// Every light is a lamp of its own.
    pub fn points() -> Self {
        Self { of: std::array::from_fn(|light| light as u8), count: MAX_LIGHTS as u8 }
    }

    /// Lamps with these numbers of points, at most [`MAX_LIGHTS`] points in all; readers of scenes check this limit.
    pub fn of_sizes(sizes: impl IntoIterator<Item = usize>) -> Self {
        let mut lamps = Self { of: [0; MAX_LIGHTS], count: 0 };
        let mut points = lamps.of.iter_mut();
        for size in sizes {
            let placed = points.by_ref().take(size).map(|of| *of = lamps.count).count();
            assert_eq!(placed, size, "a scene has at most {MAX_LIGHTS} lights");
            lamps.count += 1;
        }
        lamps
    }

    /// The lamp of `light`.
    pub fn of(&self, light: LightId) -> LightId {
        LightId(self.of[usize::from(light.0)])
    }

    /// Number of lamps in a scene of `lights` lights.
    pub fn count(&self, lights: usize) -> usize {
        lights.min(usize::from(self.count))
    }

    /// The lights of a lamp, in a scene of `lights` lights.
    pub fn lights(&self, lamp: LightId, lights: usize) -> impl Iterator<Item = LightId> + use<> {
        let of = self.of;
        (0..lights as u8).map(LightId).filter(move |light| of[usize::from(light.0)] == lamp.0)
    }
}

/// The points of a rectangle with half edges `half` around `centre`: the middles of `side` x `side` equal parts, row by
/// row, each with an equal share of `color`. All pixels use the same points, so each point is an ordinary light for the
/// tracer.
pub fn rectangle(centre: DVec3, half: [DVec3; 2], side: usize, color: Vec3) -> impl Iterator<Item = Light> {
    let share = color / (side * side) as f32;
    let at = move |step: usize| (2 * step + 1) as f64 / side as f64 - 1.0;
    (0..side * side).map(move |point| {
        let position = centre + half[0] * at(point % side) + half[1] * at(point / side);
        Light { position: position.as_vec3(), color: share }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_by_hand() {
        let lamps = Lamps::of_sizes([1, 4, 1]);
        let of: Vec<_> = (0..6).map(|light| lamps.of(LightId(light)).0).collect();
        assert_eq!((of, lamps.count(6)), (vec![0, 1, 1, 1, 1, 2], 3));
        assert_eq!(lamps.lights(LightId(1), 6).map(|light| light.0).collect::<Vec<_>>(), [1, 2, 3, 4]);
        assert_eq!((Lamps::points().of(LightId(63)), Lamps::points().count(5)), (LightId(63), 5));
    }

    #[test]
    fn a_rectangles_points_lie_in_the_middle_of_its_parts() {
        let points: Vec<_> = rectangle(DVec3::Y, [DVec3::X * 2.0, DVec3::Z], 2, Vec3::ONE).collect();
        let at = points.iter().map(|light| light.position.to_array());
        assert_eq!(at.collect::<Vec<_>>(), [[-1.0, 1.0, -0.5], [1.0, 1.0, -0.5], [-1.0, 1.0, 0.5], [1.0, 1.0, 0.5]]);
        assert_eq!(points[0].color, Vec3::splat(0.25));
    }
}
