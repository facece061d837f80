//! The slab test of eight boxes at once.

use std::array;

use super::lanes::Lanes;
use super::ray::{Boxes, Ray, SLAB};

/// A ray as the slab test of eight boxes wants it.
///
/// The test is that of [`Ray::entries`], with the same answers. Along an axis that the ray runs across, the inverse
/// direction is infinite here: a plane on one side of the ray is then crossed at minus infinity, one on the other side
/// at infinity, and the product of a plane that the ray lies in is a NaN, which never wins a comparison.
pub(super) struct Slabs<L: Lanes<8>> {
    lanes: L,
    origin: [L::F; 3],
    inverse: [L::F; 3],
    /// By axis, which plane of a box is crossed first.
    first: [usize; 3],
    slab: L::F,
    /// How far the ray goes, rounding allowed for; finite, so that a box at infinity is never met.
    limit: L::F,
}

impl<L: Lanes<8>> Slabs<L> {
    /// The ray up to its reach.
    #[inline(always)]
    pub(super) fn new(lanes: L, ray: &Ray) -> Self {
        let inverse = ray.inverse_or_infinity();
        Self {
            lanes,
            origin: array::from_fn(|axis| lanes.splat(ray.origin[axis])),
            inverse: array::from_fn(|axis| lanes.splat(inverse[axis])),
            first: array::from_fn(|axis| ray.first_plane(axis)),
            slab: lanes.splat(SLAB),
            limit: lanes.splat(limit(ray)),
        }
    }

    /// The ray goes no farther than `ray` does.
    #[inline(always)]
    pub(super) fn shorten(&mut self, ray: &Ray) {
        self.limit = self.lanes.splat(limit(ray));
    }

    /// Where the ray enters each of eight boxes, and a bit for each that it meets.
    #[inline(always)]
    pub(super) fn meet(&self, boxes: &Boxes<8>) -> ([f32; 8], u32) {
        let lanes = self.lanes;
        let cross = |axis: usize, side: usize| {
            let planes = lanes.load(&boxes[axis][side & 1]);
            lanes.mul(lanes.sub(planes, self.origin[axis]), self.inverse[axis])
        };
        let [x, y, z] = self.first;
        let near = lanes.larger(cross(0, x), lanes.splat(0.0));
        let near = lanes.larger(cross(1, y), near);
        let near = lanes.larger(cross(2, z), near);
        let far = lanes.smaller(cross(0, x ^ 1), lanes.splat(f32::INFINITY));
        let far = lanes.smaller(cross(1, y ^ 1), far);
        let far = lanes.smaller(cross(2, z ^ 1), far);
        let far = lanes.smaller(lanes.mul(far, self.slab), self.limit);
        (lanes.store(near), lanes.at_most(near, far))
    }
}

/// The last distance at which a box may be entered.
#[inline(always)]
pub(super) fn limit(ray: &Ray) -> f32 {
    (ray.reach * SLAB).min(f32::MAX)
}
