//! The kd-tree as an acceleration structure.

use glam::Vec3;

use super::build::{BuildSpec, build};
use super::node::{Node, Tree};
use super::traverse::Forest;
use crate::accel::query::{Hit, Order, Scope};
use crate::accel::ray::Ray;
use crate::accel::shaft::{Shaft, Sight};
use crate::accel::spec::{AccelSpec, Quality};
use crate::accel::structure::{Base, Item, JoinedTree, Sizes, StaticTree};
use crate::accel::trail::Observer;
use crate::accel::triangle::Record;
use crate::quantity::{PrimitiveId, TriangleSlot};

/// The static kd-tree.
pub(crate) struct KdTree {
    tree: Tree,
    /// Whether node 0 joins the tree with dynamic ones.
    joined: bool,
}

fn build_spec(spec: &AccelSpec, quality: Quality) -> BuildSpec {
    let max_depth = spec.kd_depth.map(|depth| depth.get() as u32);
    let leaf = spec.kd_leaf.map_or(0, |triangles| triangles.size());
    BuildSpec { quality, layout: spec.kd_layout, max_depth, leaf }
}

impl StaticTree for KdTree {
    type Joined<'a> = Forest<'a>;

    fn build(items: &[Item<'_>], spec: &AccelSpec, joined: bool) -> Self {
        let base = Base { node: u32::from(joined), ..Base::default() };
        let mut tree = build(items, build_spec(spec, spec.statics), base);
        if joined || items.is_empty() {
            tree.nodes.insert(0, Node::leaf(0..0));
        }
        Self { tree, joined }
    }

    fn join<'a>(&'a self, items: &[Item<'_>], spec: &AccelSpec) -> Forest<'a> {
        let dynamic = build(items, build_spec(spec, spec.dynamic), self.end());
        let short_stack = spec.kd_stack.map(|places| places.size());
        Forest { joined: self.joined, statics: &self.tree, dynamic, short_stack }
    }

    fn sizes(&self) -> Sizes {
        Sizes { nodes: self.tree.nodes.len() as u32, list_entries: self.tree.lists.len() as u32 }
    }

    fn records(&self) -> &[Record] {
        &self.tree.records
    }
}

impl JoinedTree for Forest<'_> {
    fn dynamic_sizes(&self) -> Sizes {
        Sizes { nodes: self.dynamic.nodes.len() as u32, list_entries: self.dynamic.lists.len() as u32 }
    }

    fn dynamic_records(&self) -> &[Record] {
        &self.dynamic.records
    }

    fn record(&self, slot: TriangleSlot) -> &Record {
        let slot = slot.0 as usize;
        self.statics.records.get(slot).unwrap_or_else(|| &self.dynamic.records[slot - self.statics.records.len()])
    }

    fn static_bounds(&self) -> (Vec3, Vec3) {
        (self.statics.bounds.low, self.statics.bounds.high)
    }

    fn closest(&self, ray: &Ray, watch: &mut impl Observer) -> Option<Hit> {
        self.nearest(*ray, watch)
    }

    /// Walks front to back and ignores the order.
    fn occluded(&self, ray: &Ray, scope: Scope, _: Order, watch: &mut impl Observer) -> Option<PrimitiveId> {
        self.blocker(ray, scope, watch)
    }

    fn sight(&self, shaft: &Shaft, watch: &mut impl Observer) -> Sight {
        self.look(shaft, watch)
    }

    /// A kd-tree's cells need not enclose a triangle's box: only a hit by more than rounding is certain to be found.
    fn blocks(&self, ray: &Ray, slot: TriangleSlot, watch: &mut impl Observer) -> bool {
        let (stop, blocked) = self.record(slot).surely_blocks(ray);
        watch.triangle(slot, stop);
        blocked
    }
}
