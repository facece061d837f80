//! What a ray is asked that walks a tree of boxes.

use crate::accel::query::{Hit, Order};
use crate::accel::ray::Ray;
use crate::accel::triangle::{Record, TriangleHit};
use crate::quantity::PrimitiveId;
use crate::stream::Stop;

/// A question, and what is known of its answer.
pub(super) trait Question<'a> {
    /// The order in which it visits children.
    fn order(&self) -> Order;
    /// The ray as far as it goes.
    fn ray(&self) -> &Ray;
    /// Whether hits shorten the ray.
    const SHORTENS: bool;
    /// Takes in a hit on the triangle of `primitive`, whose record `record` gives: tells where the hardware's test
    /// ends, and whether the question is answered.
    fn hit(&mut self, hit: TriangleHit, primitive: PrimitiveId, record: impl FnOnce() -> &'a Record) -> (Stop, bool);
}

/// Which hit is the nearest, at equal distance that on the lowest primitive.
pub(super) struct Nearest {
    pub ray: Ray,
    pub hit: Option<Hit>,
}

impl<'a> Question<'a> for Nearest {
    const SHORTENS: bool = true;

    #[inline(always)]
    fn order(&self) -> Order {
        Order::NearestFirst
    }

    #[inline(always)]
    fn ray(&self) -> &Ray {
        &self.ray
    }

    #[inline(always)]
    fn hit(&mut self, hit: TriangleHit, primitive: PrimitiveId, _: impl FnOnce() -> &'a Record) -> (Stop, bool) {
        hit.keep_nearest(primitive, &mut self.ray, &mut self.hit);
        (Stop::Hit, false)
    }
}

/// Whether anything blocks the ray.
pub(super) struct Blocker<'a> {
    pub ray: &'a Ray,
    pub order: Order,
    pub found: Option<PrimitiveId>,
}

impl<'a> Question<'a> for Blocker<'_> {
    const SHORTENS: bool = false;

    #[inline(always)]
    fn order(&self) -> Order {
        self.order
    }

    #[inline(always)]
    fn ray(&self) -> &Ray {
        self.ray
    }

    #[inline(always)]
    fn hit(&mut self, hit: TriangleHit, primitive: PrimitiveId, record: impl FnOnce() -> &'a Record) -> (Stop, bool) {
        let (stop, blocks) = record().confirm(self.ray, hit.t);
        if blocks {
            self.found = Some(primitive);
        }
        (stop, blocks)
    }
}
