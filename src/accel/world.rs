//! What rays can meet in one frame, and the queries about it.

use glam::Vec3;

use super::kind::{AnyJoined, on};
use super::query::{Hit, Order, Scope};
use super::ray::Ray;
use super::shaft::{Relation, Shaft, Sight};
use super::structure::JoinedTree;
use super::trail::Observer;
use super::triangle::Record;
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};
use crate::stream::FrameInfo;

/// Everything that rays can meet in one frame.
pub struct World<'a> {
    tree: AnyJoined<'a>,
    info: FrameInfo,
    static_slots: &'a [TriangleSlot],
    /// Slots of dynamic primitives, counted from the first dynamic slot.
    dynamic_slots: Vec<TriangleSlot>,
}

impl<'a> World<'a> {
    /// The world of a frame, with the slots of static and of dynamic primitives.
    pub(super) fn new(
        tree: AnyJoined<'a>,
        info: FrameInfo,
        static_slots: &'a [TriangleSlot],
        dynamic_slots: Vec<TriangleSlot>,
    ) -> Self {
        Self { tree, info, static_slots, dynamic_slots }
    }

    /// Sizes of the frame's dynamic part.
    pub fn info(&self) -> FrameInfo {
        self.info
    }

    /// The nearest hit; at equal distance the one on the lowest primitive.
    pub fn closest(&self, ray: &Ray, watch: &mut impl Observer) -> Option<Hit> {
        on!(&self.tree, tree => tree.closest(ray, watch))
    }

    /// A triangle that blocks the ray; if it is dynamic, no static triangle blocks the ray.
    pub fn occluded(&self, ray: &Ray, scope: Scope, watch: &mut impl Observer) -> Option<PrimitiveId> {
        self.occluded_in_order(ray, scope, Order::NearestFirst, watch)
    }

    /// A triangle that blocks the ray, with the children of a BVH's nodes visited in `order`. The order decides which
    /// blocker is found, not whether one is found. A kd-tree is walked front to back.
    pub fn occluded_in_order(
        &self,
        ray: &Ray,
        scope: Scope,
        order: Order,
        watch: &mut impl Observer,
    ) -> Option<PrimitiveId> {
        on!(&self.tree, tree => tree.occluded(ray, scope, order, watch))
    }

    /// A static triangle below the static node `node` of a BVH that blocks the ray.
    pub fn occluded_below(&self, ray: &Ray, node: NodeId, watch: &mut impl Observer) -> Option<PrimitiveId> {
        on!(&self.tree, tree => tree.occluded_below(ray, node, watch))
    }

    /// Whether one visible primitive's triangle blocks the ray. If it does, [`World::occluded`] finds a blocker too.
    pub fn blocks(&self, ray: &Ray, primitive: PrimitiveId, watch: &mut impl Observer) -> bool {
        on!(&self.tree, tree => tree.blocks(ray, self.slot(primitive), watch))
    }

    /// The node `levels` levels above the leaf of a static primitive; at most the static tree's root. Level 1 is the
    /// node that holds the leaf. Only for a BVH.
    pub fn ancestor(&self, primitive: PrimitiveId, levels: u32) -> NodeId {
        on!(&self.tree, tree => tree.ancestor(self.slot(primitive), levels))
    }

    /// The box around all static triangles; empty if there are none.
    pub fn static_bounds(&self) -> (Vec3, Vec3) {
        on!(&self.tree, tree => tree.static_bounds())
    }

    /// Tests one visible primitive's triangle; returns the distance of the hit, if there is one.
    pub fn test(&self, ray: &Ray, primitive: PrimitiveId, watch: &mut impl Observer) -> Option<f32> {
        let slot = self.slot(primitive);
        let (stop, hit) = self.record(slot).test(ray);
        watch.triangle(slot, stop);
        hit.map(|hit| hit.t)
    }

    /// A static triangle's record.
    pub fn static_record(&self, primitive: PrimitiveId) -> &Record {
        self.record(self.static_slots[primitive.0 as usize])
    }

    /// Looks for static blockers of the rays of `shaft`.
    pub fn sight(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight {
        on!(&self.tree, tree => tree.sight(shaft, watch))
    }

    /// The relation of a static triangle to the rays of `shaft`.
    pub fn relation(&self, shaft: &Shaft, primitive: PrimitiveId, watch: &mut impl Observer) -> Relation {
        let slot = self.slot(primitive);
        shaft.test(slot, self.record(slot), watch)
    }

    /// Whether one visible primitive's triangle is certain to block `ray`, so that a traversal of the tree finds a
    /// blocker.
    pub fn surely_blocked(&self, ray: &Ray, primitive: PrimitiveId, watch: &mut impl Observer) -> bool {
        let slot = self.slot(primitive);
        let (stop, blocked) = self.record(slot).surely_blocks(ray);
        watch.triangle(slot, stop);
        blocked
    }

    fn record(&self, slot: TriangleSlot) -> &Record {
        on!(&self.tree, tree => tree.record(slot))
    }

    fn slot(&self, primitive: PrimitiveId) -> TriangleSlot {
        let index = primitive.0 as usize;
        match index.checked_sub(self.static_slots.len()) {
            None => self.static_slots[index],
            Some(index) => TriangleSlot(self.static_slots.len() as u32 + self.dynamic_slots[index].0),
        }
    }
}
