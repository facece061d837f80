//! Cuts polygons into triangles, the same way for every format.

use earcut::{Earcut, deviation};
use glam::DVec3;

/// The largest number of corners of a polygon.
pub(super) const MAX_CORNERS: usize = 1 << 16;

/// The share of a polygon's area that triangles may miss: corners are `f32`, hence rounded by some 1e-7.
const TOLERANCE: f64 = 1e-6;

/// Cuts polygons; reuses its memory for each.
#[derive(Default)]
pub(super) struct Cutter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    indices: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

/// The result of cutting a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// The triangles cover it.
    Whole,
    /// It crosses itself, so its area is not defined; a fan from its first corner replaces it.
    CrossesItself,
}

impl Cutter {
    /// Indices of the corners of each triangle, in the polygon's direction, and the result. A polygon that a fan from
    /// its first corner covers becomes that fan. Any other is seen along the axis nearest to its mean normal (Newell's)
    /// and cut by ears. `corners` are three or more.
    pub(super) fn cut(&mut self, corners: &[DVec3]) -> (&[[u32; 3]], Cut) {
        self.triangles.clear();
        self.triangles.extend((1..corners.len() as u32 - 1).map(|corner| [0, corner, corner + 1]));
        let cut = if corners.len() == 3 || fan_covers(corners) { Cut::Whole } else { self.cut_ears(corners) };
        (&self.triangles, cut)
    }

    fn cut_ears(&mut self, corners: &[DVec3]) -> Cut {
        let normal = newell(corners);
        // Seen along the axis nearest to the normal, counter-clockwise if the normal points to the viewer.
        let axis = normal.abs().max_position();
        let (right, up) =
            if normal[axis] > 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|corner| [corner[right], corner[up]]));
        self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.indices);
        let misses = deviation(self.flat.iter().copied(), &[], &self.indices);
        if normal == DVec3::ZERO || misses.is_nan() || misses > TOLERANCE {
            return Cut::CrossesItself;
        }
        self.triangles.clear();
        for &[a, b, c] in self.indices.as_chunks().0 {
            let [p, q, r] = [a, b, c].map(|index: u32| self.flat[index as usize]);
            let turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            self.triangles.push(if turn < 0.0 { [a, c, b] } else { [a, b, c] });
        }
        Cut::Whole
    }
}

/// The normals of the fan's triangles; their lengths are twice the triangles' areas.
fn fan(corners: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let first = corners[0];
    corners[1..].array_windows().map(move |&[b, c]| (b - first).cross(c - first))
}

/// The sum of the fan's normals, which does not depend on the corner that it starts from.
fn newell(corners: &[DVec3]) -> DVec3 {
    fan(corners).sum()
}

/// Whether no triangle of the fan overlaps another: all turn the same way. Collinear corners have no area to cover.
fn fan_covers(corners: &[DVec3]) -> bool {
    let normal = newell(corners);
    let least = fan(corners).map(|part| part.dot(normal)).fold(f64::INFINITY, f64::min);
    if normal == DVec3::ZERO {
        fan(corners).all(|part| part == DVec3::ZERO)
    } else {
        least >= -TOLERANCE * normal.length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area of the triangles, and of those that face against `up`.
    fn areas(corners: &[DVec3], up: DVec3) -> (f64, f64, Cut) {
        let mut cutter = Cutter::default();
        let (triangles, cut) = cutter.cut(corners);
        let areas = triangles.iter().map(|corner| {
            let [a, b, c] = corner.map(|index| corners[index as usize]);
            0.5 * (b - a).cross(c - a).dot(up)
        });
        let areas: Vec<f64> = areas.collect();
        (areas.iter().sum(), areas.iter().filter(|area| **area < 0.0).sum(), cut)
    }

    fn flat(corners: &[[f64; 2]]) -> Vec<DVec3> {
        corners.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect()
    }

    #[test]
    fn convex_polygons_become_fans() {
        let mut cutter = Cutter::default();
        let square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]]);
        assert_eq!(cutter.cut(&square), (&[[0, 1, 2], [0, 2, 3], [0, 3, 4]][..], Cut::Whole));
    }

    #[test]
    fn concave_polygons_are_covered_in_every_direction() {
        let arrow = flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.25], [0.0, 2.0]]);
        let expected = 4.0 - 0.5 * 2.0 * 1.75;
        let turns: [fn(DVec3) -> DVec3; 4] =
            [|p| p, |p| DVec3::new(p.z, p.x, p.y), |p| DVec3::new(p.y, p.z, p.x), |p| DVec3::new(p.y, p.x, p.z)];
        for turn in turns {
            for start in 0..arrow.len() {
                let mut corners: Vec<_> = arrow.iter().map(|corner| turn(*corner)).collect();
                corners.rotate_left(start);
                // The last one is a mirror: the polygon turns the other way.
                let up = turn(DVec3::X).cross(turn(DVec3::Y));
                let (area, against, cut) = areas(&corners, up);
                assert!((area - expected).abs() < 1e-12, "{area} from corner {start}");
                assert_eq!((against, cut), (0.0, Cut::Whole));
            }
        }
    }

    #[test]
    fn bent_polygons_are_cut_as_seen_along_their_normal() {
        let mut corners = flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.25], [0.0, 2.0]]);
        corners[3].z = 0.1;
        let (area, against, cut) = areas(&corners, DVec3::Z);
        assert!((area - 2.25).abs() < 1e-12, "{area}");
        assert_eq!((against, cut), (0.0, Cut::Whole));
    }

    #[test]
    fn degenerate_polygons_do_no_harm() {
        let line = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]]);
        assert_eq!(areas(&line, DVec3::Z), (0.0, 0.0, Cut::Whole));
        let bow = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(areas(&bow, DVec3::Z).2, Cut::CrossesItself);
        let uneven = flat(&[[0.0, 0.0], [3.0, 2.0], [3.0, 0.0], [0.0, 1.0]]);
        assert_eq!(areas(&uneven, DVec3::Z).2, Cut::CrossesItself);
        let point = flat(&[[1.0, 1.0]; 6]);
        assert_eq!(areas(&point, DVec3::Z), (0.0, 0.0, Cut::Whole));
    }

    #[test]
    fn a_comb_of_many_teeth_is_cut_in_time() {
        let teeth = MAX_CORNERS / 2 - 1;
        let mut corners: Vec<_> = (0..2 * teeth).rev().map(|at| [at as f64 / 2.0, (at % 2) as f64]).collect();
        corners.extend([[0.0, -1.0], [teeth as f64, -1.0]]);
        let (area, against, cut) = areas(&flat(&corners), DVec3::Z);
        assert_eq!((against, cut), (0.0, Cut::Whole));
        assert!(area > teeth as f64, "{area}");
    }
}
