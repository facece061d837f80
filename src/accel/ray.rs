//! The ray in the form that a traversal needs.

use glam::Vec3;

/// A ray, or the part of it up to `reach`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// The ray's start.
    pub origin: Vec3,
    /// The ray's direction; any length but zero. Distances are in units of this length.
    pub direction: Vec3,
    /// One over the direction, finite in every component.
    pub inverse: Vec3,
    /// Hits beyond this distance do not count.
    pub reach: f32,
    /// For each axis, the plane of a box that is crossed first: 1 (the upper plane) where the direction is negative.
    first: [u8; 3],
    /// Whether the ray is perpendicular to at least one axis.
    is_parallel: bool,
}

/// The bounds of `N` boxes: for each axis the lower planes, then the upper planes.
pub type Boxes<const N: usize> = [[[f32; N]; 2]; 3];

/// Smallest magnitude of a direction component: a slab test must not multiply zero by infinity. No `f32` coordinate
/// can show how far this moves a ray.
const SMALLEST_COMPONENT: f32 = 1e-20;

/// Widens the far side of a slab test, and the reach of a ray, by more than the rounding error: 1 + 2 gamma(3),
/// rounded up (Ize 2013, "Robust BVH Ray Traversal").
pub(super) const SLAB: f32 = 1.0 + 8.0 * f32::EPSILON;

impl Ray {
    /// A ray from `origin` along `direction`, hits at `0 < t < reach`.
    pub fn new(origin: Vec3, direction: Vec3, reach: f32) -> Self {
        let safe = |component: f32| {
            if component.abs() < SMALLEST_COMPONENT { SMALLEST_COMPONENT.copysign(component) } else { component }
        };
        let inverse = Vec3::new(1.0 / safe(direction.x), 1.0 / safe(direction.y), 1.0 / safe(direction.z));
        let first = inverse.to_array().map(|inverse| u8::from(inverse < 0.0));
        let is_parallel = direction.abs().min_element() <= SMALLEST_COMPONENT;
        Self { origin, direction, inverse, reach, first, is_parallel }
    }

    /// The distance at which the ray enters each of `N` boxes; infinity for a box that it misses. Each step of the
    /// arithmetic is monotone: a ray that meets a box meets every box around it.
    #[inline(always)]
    pub fn entries<const N: usize>(&self, bounds: &Boxes<N>) -> [f32; N] {
        if self.is_parallel {
            return self.entries_in_plane(bounds);
        }
        let (mut near, mut far) = ([0.0f32; N], [self.reach; N]);
        for (axis, planes) in bounds.iter().enumerate() {
            self.cross(axis, planes, &mut near, &mut far);
        }
        met(near, far)
    }

    /// [`Ray::entries`] for a ray that is perpendicular to an axis. Such a ray crosses no plane of that axis; the
    /// usual test would drop a ray that lies in the face of a box.
    #[cold]
    fn entries_in_plane<const N: usize>(&self, bounds: &Boxes<N>) -> [f32; N] {
        let (mut near, mut far) = ([0.0f32; N], [self.reach; N]);
        for (axis, planes) in bounds.iter().enumerate() {
            if !self.is_parallel(axis) {
                self.cross(axis, planes, &mut near, &mut far);
                continue;
            }
            let (origin, [low, high]) = (self.origin[axis], planes);
            for at in 0..N {
                if origin < low[at] || origin > high[at] {
                    near[at] = f32::INFINITY;
                }
            }
        }
        met(near, far)
    }

    /// Narrows the ray's interval in each box by the planes of an axis.
    #[inline(always)]
    fn cross<const N: usize>(&self, axis: usize, planes: &[[f32; N]; 2], near: &mut [f32; N], far: &mut [f32; N]) {
        let (origin, inverse) = (self.origin[axis], self.inverse[axis]);
        let first = usize::from(self.first[axis] & 1);
        let (entry, exit) = (&planes[first], &planes[1 - first]);
        for at in 0..N {
            near[at] = larger(near[at], (entry[at] - origin) * inverse);
            far[at] = smaller(far[at], (exit[at] - origin) * inverse);
        }
    }

    /// Whether the ray is perpendicular to `axis`, so that it crosses no plane of this axis.
    pub fn is_parallel(&self, axis: usize) -> bool {
        self.direction[axis].abs() <= SMALLEST_COMPONENT
    }

    /// One over the direction; infinite along an axis that the ray is perpendicular to.
    #[inline(always)]
    pub(super) fn inverse_or_infinity(&self) -> Vec3 {
        if !self.is_parallel {
            return self.inverse;
        }
        let inverse = |axis: usize| match self.is_parallel(axis) {
            true => f32::INFINITY.copysign(self.inverse[axis]),
            false => self.inverse[axis],
        };
        Vec3::new(inverse(0), inverse(1), inverse(2))
    }

    /// The plane of a box that is crossed first on an axis: 1 (the upper plane) where the direction is negative.
    #[inline(always)]
    pub(super) fn first_plane(&self, axis: usize) -> usize {
        usize::from(self.first[axis])
    }

    /// The open segment from `origin` to `target`.
    pub fn segment(origin: Vec3, target: Vec3) -> Self {
        Self::new(origin, target - origin, 1.0)
    }
}

/// The entry distances; infinity for boxes that the ray leaves before it enters them.
#[inline(always)]
fn met<const N: usize>(mut near: [f32; N], far: [f32; N]) -> [f32; N] {
    for at in 0..N {
        if near[at] > far[at] * SLAB {
            near[at] = f32::INFINITY;
        }
    }
    near
}

/// The smaller of two numbers that are not NaN: one instruction, where `f32::min` takes several.
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers that are not NaN.
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
