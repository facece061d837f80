//! What a kind of tree must offer: a static tree that is built once, and its join with a frame's dynamic tree.

use glam::Vec3;

use super::query::{Hit, Order, Scope};
use super::ray::Ray;
use super::shaft::{Shaft, Sight};
use super::spec::AccelSpec;
use super::trail::Observer;
use super::triangle::Record;
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};
use crate::scene::Triangle;

/// A triangle to build a tree over, and its primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item<'a> {
    /// The triangle's primitive.
    pub primitive: PrimitiveId,
    /// The triangle's corners.
    pub triangle: &'a Triangle,
}

/// First ids of a tree's nodes, slots and list entries.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Base {
    /// The id of the tree's root.
    pub node: u32,
    /// The tree's first triangle slot.
    pub slot: u32,
    /// The tree's first entry of primitive lists.
    pub list: u32,
}

/// Sizes of a tree.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sizes {
    /// Number of nodes.
    pub nodes: u32,
    /// Number of entries of primitive lists.
    pub list_entries: u32,
}

/// A tree over static triangles.
pub(super) trait StaticTree: Sized {
    /// The static tree and a frame's dynamic tree under one root.
    type Joined<'a>: JoinedTree
    where
        Self: 'a;

    /// Builds the tree. Node 0 is its root. If the tree will be `joined` with dynamic trees, node 0 is reserved for
    /// the root that joins them.
    fn build(items: &[Item<'_>], spec: &AccelSpec, joined: bool) -> Self;

    /// Builds the dynamic tree of a frame, and joins it if the static tree was built with `joined`.
    fn join<'a>(&'a self, items: &[Item<'_>], spec: &AccelSpec) -> Self::Joined<'a>;

    /// Sizes, including node 0.
    fn sizes(&self) -> Sizes;

    /// Triangle records by slot.
    fn records(&self) -> &[Record];

    /// The first free ids after this tree.
    fn end(&self) -> Base {
        let Sizes { nodes, list_entries } = self.sizes();
        Base { node: nodes, slot: self.records().len() as u32, list: list_entries }
    }
}

/// Why some methods are never called on a kd-tree.
const BOXES_ONLY: &str = "a policy that needs a tree of boxes is refused with a kd-tree before it is built";

/// Everything that rays can meet in a frame. Ids are global: static ones first, then dynamic ones.
pub(super) trait JoinedTree {
    /// Sizes of the dynamic tree.
    fn dynamic_sizes(&self) -> Sizes;

    /// Triangle records of the dynamic tree.
    fn dynamic_records(&self) -> &[Record];

    /// The record in a slot.
    fn record(&self, slot: TriangleSlot) -> &Record;

    /// The box around all static triangles; empty if there are none.
    fn static_bounds(&self) -> (Vec3, Vec3);

    /// The nearest hit; at equal distance, the hit on the lowest primitive.
    fn closest(&self, ray: &Ray, watch: &mut impl Observer) -> Option<Hit>;

    /// A triangle that blocks the ray within `scope`: the first found with children visited in `order`. All static
    /// triangles are tried before the first dynamic one, so a dynamic blocker proves that no static triangle blocks.
    fn occluded(&self, ray: &Ray, scope: Scope, order: Order, watch: &mut impl Observer) -> Option<PrimitiveId>;

    /// Looks for static blockers in the shaft, up to the first triangle that the shaft does not miss.
    fn sight(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight;

    /// Whether the triangle in `slot` blocks the ray. If it does, [`JoinedTree::occluded`] finds a blocker too.
    fn blocks(&self, ray: &Ray, slot: TriangleSlot, watch: &mut impl Observer) -> bool;

    /// A static triangle below a static node that blocks the ray. Only trees of boxes support this.
    fn occluded_below(&self, _ray: &Ray, _node: NodeId, _watch: &mut impl Observer) -> Option<PrimitiveId> {
        unreachable!("{BOXES_ONLY}")
    }

    /// The node `levels` levels above the leaf of a static slot; at most the static root. Level 1 is the node that
    /// holds the leaf. Only trees of boxes support this.
    fn ancestor(&self, _slot: TriangleSlot, _levels: u32) -> NodeId {
        unreachable!("{BOXES_ONLY}")
    }
}
