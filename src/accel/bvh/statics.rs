//! Trees of boxes as acceleration structures.

use glam::Vec3;

use super::ancestry::Ancestry;
use super::build::{Build, params};
use super::forest::Forest;
use super::packed::{NO_BOXES, Packed, Wide, set_box};
use super::tree::{Node, Tree};
use crate::accel::query::{Hit, Order, Scope};
use crate::accel::ray::Ray;
use crate::accel::shaft::{Shaft, Sight};
use crate::accel::spec::AccelSpec;
use crate::accel::structure::{Base, Item, JoinedTree, Sizes, StaticTree};
use crate::accel::trail::Observer;
use crate::accel::triangle::Record;
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};

/// The static tree of boxes.
pub(crate) struct Bvh<const N: usize>
where
    Tree<N>: Wide<N>,
{
    tree: Tree<N>,
    packed: Packed<<Tree<N> as Wide<N>>::Node>,
    ancestry: Ancestry,
    /// Whether node 0 joins the tree with dynamic ones.
    joined: bool,
}

impl<const N: usize> StaticTree for Bvh<N>
where
    Tree<N>: Build + Wide<N>,
{
    type Joined<'a> = Forest<'a, N>;

    fn build(items: &[Item<'_>], spec: &AccelSpec, joined: bool) -> Self {
        let mut tree = if items.is_empty() {
            Tree::default()
        } else {
            Tree::build(items, params(spec.statics, items.len()), Base { node: u32::from(joined), ..Base::default() })
        };
        if joined || items.is_empty() {
            tree.nodes.insert(0, Node::default());
        }
        let ancestry = Ancestry::of(&tree);
        let packed = Packed::new(&tree, Base::default());
        Self { tree, packed, ancestry, joined }
    }

    fn join<'a>(&'a self, items: &[Item<'_>], spec: &AccelSpec) -> Forest<'a, N> {
        let base = self.end();
        let dynamic = if items.is_empty() {
            Tree::default()
        } else {
            Tree::build(items, params(spec.dynamic, items.len()), base)
        };
        let mut boxes = NO_BOXES;
        for (tree, root) in [self.tree.nodes.get(1), dynamic.nodes.first()].into_iter().enumerate() {
            if let Some(root) = root {
                set_box(&mut boxes, tree, root.bounds());
            }
        }
        let packed_dynamic = Packed::new(&dynamic, base);
        Forest {
            boxes,
            joined: self.joined,
            statics: &self.tree,
            packed: &self.packed,
            ancestry: &self.ancestry,
            dynamic,
            packed_dynamic,
        }
    }

    fn sizes(&self) -> Sizes {
        Sizes { nodes: self.tree.nodes.len() as u32, list_entries: 0 }
    }

    fn records(&self) -> &[Record] {
        &self.tree.records
    }
}

impl<const N: usize> JoinedTree for Forest<'_, N>
where
    Tree<N>: Wide<N>,
{
    fn dynamic_sizes(&self) -> Sizes {
        Sizes { nodes: self.dynamic.nodes.len() as u32, list_entries: 0 }
    }

    fn dynamic_records(&self) -> &[Record] {
        &self.dynamic.records
    }

    fn record(&self, slot: TriangleSlot) -> &Record {
        let slot = slot.0 as usize;
        self.statics.records.get(slot).unwrap_or_else(|| &self.dynamic.records[slot - self.statics.records.len()])
    }

    fn static_bounds(&self) -> (Vec3, Vec3) {
        let root = if self.joined { self.statics.nodes.get(1) } else { self.statics.nodes.first() };
        root.unwrap_or(&Node::default()).bounds()
    }

    fn closest(&self, ray: &Ray, watch: &mut impl Observer) -> Option<Hit> {
        self.nearest(ray, watch)
    }

    fn occluded(&self, ray: &Ray, scope: Scope, order: Order, watch: &mut impl Observer) -> Option<PrimitiveId> {
        self.blocker(ray, scope, order, watch)
    }

    fn sight(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight {
        self.look(shaft, watch)
    }

    fn blocks(&self, ray: &Ray, slot: TriangleSlot, watch: &mut impl Observer) -> bool {
        let (stop, blocked) = self.record(slot).blocks(ray);
        watch.triangle(slot, stop);
        blocked
    }

    fn occluded_below(&self, ray: &Ray, node: NodeId, watch: &mut impl Observer) -> Option<PrimitiveId> {
        self.blocker_below(ray, node, watch)
    }

    fn ancestor(&self, slot: TriangleSlot, levels: u32) -> NodeId {
        self.ancestry.ancestor(slot, levels)
    }
}
