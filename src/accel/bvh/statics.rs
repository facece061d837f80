//! Trees of boxes as acceleration structures.

use glam::Vec3;

use super::ancestry::Ancestry;
use super::build::{Build, params};
use super::forest::Forest;
use super::tree::{Child, Node, Tree};
use super::walk::nearest;
use crate::accel::query::{Hit, Order, Scope};
use crate::accel::ray::Ray;
use crate::accel::shaft::{Shaft, Sight};
use crate::accel::spec::AccelSpec;
use crate::accel::structure::{Base, Item, JoinedTree, Sizes, StaticTree};
use crate::accel::trail::Observer;
use crate::accel::triangle::Record;
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};

/// The static tree of boxes.
pub(crate) struct Bvh<const N: usize> {
    tree: Tree<N>,
    ancestry: Ancestry,
    /// Whether node 0 joins the tree with dynamic ones.
    joined: bool,
}

impl<const N: usize> StaticTree for Bvh<N>
where
    Tree<N>: Build,
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
        Self { tree, ancestry, joined }
    }

    fn join<'a>(&'a self, items: &[Item<'_>], spec: &AccelSpec) -> Forest<'a, N> {
        let base = self.end();
        let dynamic = if items.is_empty() {
            Tree::default()
        } else {
            Tree::build(items, params(spec.dynamic, items.len()), base)
        };
        let mut root = self.tree.nodes[0];
        if self.joined {
            let trees = [(self.tree.nodes.get(1), 1), (dynamic.nodes.first(), base.node)];
            for (at, (tree, index)) in trees.into_iter().enumerate() {
                if let Some(tree) = tree {
                    let (low, high) = tree.bounds();
                    root.set(at, Child { index, count: 0 }, low, high);
                }
            }
        }
        Forest { root, joined: self.joined, statics: &self.tree, ancestry: &self.ancestry, dynamic }
    }

    fn sizes(&self) -> Sizes {
        Sizes { nodes: self.tree.nodes.len() as u32, list_entries: 0 }
    }

    fn records(&self) -> &[Record] {
        &self.tree.records
    }
}

impl<const N: usize> JoinedTree for Forest<'_, N> {
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
        nearest(self, *ray, watch)
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
