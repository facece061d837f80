//! The ray as traversal wants it.

use glam::Vec3;

/// A ray, or the part of it up to `reach`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes; of any length but zero. Distances are in units of it.
    pub direction: Vec3,
    /// One over the direction, finite in every component.
    pub inverse: Vec3,
    /// Hits beyond this distance don't count.
    pub reach: f32,
}

/// Direction components smaller than this are taken as this: a slab test must not multiply zero by infinity. A ray
/// strays by it from its course, which no `f32` coordinate can show.
const SMALLEST_COMPONENT: f32 = 1e-20;

impl Ray {
    /// A ray from `origin` along `direction`, hits at `0 < t < reach`.
    pub fn new(origin: Vec3, direction: Vec3, reach: f32) -> Self {
        let safe = |component: f32| {
            if component.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(component) } else { component }
        };
        let inverse = Vec3::new(1.0 / safe(direction.x), 1.0 / safe(direction.y), 1.0 / safe(direction.z));
        Self { origin, direction, inverse, reach }
    }

    /// Whether the ray keeps its coordinate along `axis`: no plane across it is crossed.
    pub fn is_parallel(&self, axis: usize) -> bool {
        self.direction[axis].abs() <= SMALLEST_COMPONENT
    }

    /// The open segment from `origin` to `target`.
    pub fn segment(origin: Vec3, target: Vec3) -> Self {
        Self::new(origin, target - origin, 1.0)
    }
}
