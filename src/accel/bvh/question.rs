//! The queries of a ray that walks a tree of boxes.

use crate::accel::query::{Hit, Order};
use crate::accel::ray::Ray;
use crate::accel::triangle::{Record, TriangleHit};
use crate::quantity::PrimitiveId;
use crate::stream::Stop;

/// A query, and its result so far.
pub(super) trait Question<'a> {
    /// The order in which the query visits children.
    fn order(&self) -> Order;
    /// The ray, up to its present reach.
    fn ray(&self) -> &Ray;
    /// Whether hits shorten the ray.
    const SHORTENS: bool;
    /// Receives a hit on the triangle of `primitive`; `record` returns its record. Returns where the hardware's test
    /// stops, and whether the query is answered.
    fn hit(&mut self, hit: TriangleHit, primitive: PrimitiveId, record: impl FnOnce() -> &'a Record) -> (Stop, bool);
}

/// Finds the nearest hit; at equal distance, the hit on the lowest primitive.
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

/// Finds any triangle that blocks the ray.
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
