//! The slab test of eight boxes at once.

use std::array;

use super::lanes::Lanes;
use super::ray::{Boxes, Ray, SLAB};

/// A ray in the form that the slab test of eight boxes needs.
///
/// The test gives the same answers as [`Ray::entries`]. Along an axis that the ray is perpendicular to, the inverse
/// direction is infinite here. A plane on one side of the ray is then crossed at minus infinity, and a plane on the
/// other side at infinity. For a plane that the ray lies in, the product is a NaN, which never wins a comparison.
pub(super) struct Slabs<L: Lanes<8>> {
    lanes: L,
    origin: [L::F; 3],
    inverse: [L::F; 3],
    /// For each axis, the plane of a box that is crossed first.
    first: [usize; 3],
    slab: L::F,
    /// The ray's reach, widened for rounding; finite, so that a box at infinity is never met.
    limit: L::F,
}

impl<L: Lanes<8>> Slabs<L> {
    /// Converts the ray, up to its reach.
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

    /// Shortens the ray to the reach of `ray`.
    #[inline(always)]
    pub(super) fn shorten(&mut self, ray: &Ray) {
        self.limit = self.lanes.splat(limit(ray));
    }

    /// The distance at which the ray enters each of eight boxes, and a bit for each box that it meets.
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

/// The largest distance at which a box may be entered.
#[inline(always)]
pub(super) fn limit(ray: &Ray) -> f32 {
    (ray.reach * SLAB).min(f32::MAX)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use proptest::prelude::*;

    use super::*;
    use crate::accel::lanes::{Plain, Processor};

    /// Coordinates from a few values, so that rays lie in planes of boxes and meet their corners, or from many.
    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![(-3..4i32).prop_map(|it| it as f32), -3.0..3.0f32, Just(-0.0f32)]
    }

    fn point() -> impl Strategy<Value = Vec3> {
        [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from)
    }

    fn check(lanes: impl Processor, ray: &Ray, boxes: &Boxes<8>) -> Result<(), TestCaseError> {
        let (near, met) = Slabs::new(lanes, ray).meet(boxes);
        for (lane, expected) in ray.entries(boxes).into_iter().enumerate() {
            let found = if met >> lane & 1 == 1 { near[lane] } else { f32::INFINITY };
            prop_assert_eq!(found, expected, "lane {} of {:?}, {:?}", lane, ray, boxes);
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Eight boxes at once give the same answers as one by one, also for rays along axes and in planes of boxes.
        #[test]
        fn eight_boxes_are_met_as_one_by_one(
            origin in point(),
            direction in point().prop_filter("a direction", |it| *it != Vec3::ZERO),
            reach in prop_oneof![Just(f32::INFINITY), 0.0..4.0f32, Just(1.0)],
            corners in prop::array::uniform8((point(), point())),
        ) {
            let ray = Ray::new(origin, direction, reach);
            let plane = |axis: usize, side: usize, (a, b): (Vec3, Vec3)| [a.min(b), a.max(b)][side][axis];
            let boxes = array::from_fn(|axis| array::from_fn(|side| corners.map(|it| plane(axis, side, it))));
            check(Plain, &ray, &boxes)?;
            #[cfg(target_arch = "x86_64")]
            if let Some(lanes) = pulp::x86::V3::try_new() {
                check(lanes, &ray, &boxes)?;
            }
        }
    }
}
