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

/// Widens the far side of a slab test, and the reach of a ray, by more than rounding can narrow them: 1 + 2 gamma(3),
/// rounded up (Ize 2013, "Robust BVH Ray Traversal").
pub(super) const SLAB: f32 = 1.0 + 8.0 * f32::EPSILON;

impl Ray {
    /// A ray from `origin` along `direction`, hits at `0 < t < reach`.
    pub fn new(origin: Vec3, direction: Vec3, reach: f32) -> Self {
        let safe = |component: f32| {
            if component.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(component) } else { component }
        };
        let inverse = Vec3::new(1.0 / safe(direction.x), 1.0 / safe(direction.y), 1.0 / safe(direction.z));
        Self { origin, direction, inverse, reach }
    }

    /// Where the ray enters each of `N` boxes, given by their bounds by axis and box, and infinity where it misses one.
    /// Each step of the arithmetic is monotone: a ray that meets a box meets every box around it.
    #[inline(always)]
    pub fn entries<const N: usize>(&self, low: &[[f32; N]; 3], high: &[[f32; N]; 3]) -> [f32; N] {
        let mut near = [0.0f32; N];
        let mut far = [self.reach; N];
        for axis in 0..3 {
            let (origin, inverse) = (self.origin[axis], self.inverse[axis]);
            if self.is_parallel(axis) {
                // No crossing to compute: a ray in the face of a box would leave it where it enters it.
                for at in 0..N {
                    if origin < low[axis][at] || origin > high[axis][at] {
                        near[at] = f32::INFINITY;
                    }
                }
                continue;
            }
            let (entry, exit) = if inverse < 0.0 { (&high[axis], &low[axis]) } else { (&low[axis], &high[axis]) };
            for at in 0..N {
                near[at] = larger(near[at], (entry[at] - origin) * inverse);
                far[at] = smaller(far[at], (exit[at] - origin) * inverse);
            }
        }
        for at in 0..N {
            if near[at] > far[at] * SLAB {
                near[at] = f32::INFINITY;
            }
        }
        near
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

/// The smaller of two numbers that are no NaN: one instruction, where `f32::min` takes several.
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers that are no NaN.
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
