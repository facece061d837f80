//! Builds the trees with obvhs, and lays them out: depth-first nodes, triangle records in leaf order.
//!
//! obvhs only builds: its own traversal hides the nodes that it visits, and its CwBVH node test clamps the near end of a
//! ray to a fixed 1e-4.

use std::time::Duration;

use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::{BvhBuildParams, triangle::Triangle as BuildTriangle};

use super::tree::{Child, Node, Tree};
use crate::accel::spec::Quality;
use crate::accel::structure::{Base, Item};
use crate::accel::triangle::Record;

/// The parameters of obvhs for a quality.
pub fn params(quality: Quality) -> BvhBuildParams {
    let preset = match quality {
        Quality::Fast => BvhBuildParams::fast_build(),
        Quality::Medium => BvhBuildParams::medium_build(),
        Quality::Best => BvhBuildParams::very_slow_build(),
    };
    BvhBuildParams { pre_split: false, ..preset }
}

/// A node width that obvhs can build.
pub trait Build: Sized {
    /// Builds the tree over `items`, of which there is at least one.
    fn build(items: &[Item<'_>], params: BvhBuildParams, base: Base) -> Self;
}

impl Build for Tree<2> {
    fn build(items: &[Item<'_>], params: BvhBuildParams, base: Base) -> Self {
        let mut build_time = Duration::ZERO;
        let built = build_bvh2_from_tris(&corners(items), params, &mut build_time);
        lay_out(&built, items, base)
    }
}

impl Build for Tree<8> {
    fn build(items: &[Item<'_>], params: BvhBuildParams, base: Base) -> Self {
        let mut build_time = Duration::ZERO;
        let built = build_cwbvh_from_tris(&corners(items), params, &mut build_time);
        lay_out(&built, items, base)
    }
}

fn corners(items: &[Item<'_>]) -> Vec<BuildTriangle> {
    let convert = |item: &Item<'_>| {
        let [v0, v1, v2] = item.triangle.v.map(Into::into);
        BuildTriangle { v0, v1, v2 }
    };
    items.iter().map(convert).collect()
}

/// A child of a built node, with its box.
struct Part {
    at: usize,
    low: Vec3,
    high: Vec3,
    child: PartChild,
}

enum PartChild {
    Node(usize),
    Leaf { start: u32, count: u32 },
}

/// What the layout reads of a tree that obvhs built; node 0 is the root.
trait Built {
    /// The children of a node.
    fn parts(&self, node: usize) -> Vec<Part>;
    /// The primitives in leaf order.
    fn order(&self) -> &[u32];
}

impl Built for Bvh2 {
    fn parts(&self, node: usize) -> Vec<Part> {
        let part = |at: usize, node: usize| {
            let source = &self.nodes[node];
            let child = if source.is_leaf() {
                PartChild::Leaf { start: source.first_index, count: source.prim_count }
            } else {
                PartChild::Node(node)
            };
            Part { at, low: source.aabb().min.into(), high: source.aabb().max.into(), child }
        };
        if self.nodes[node].is_leaf() {
            // Only the root of a tree of one leaf: it becomes the one child of a node.
            return vec![part(0, node)];
        }
        let first = self.nodes[node].first_index as usize;
        vec![part(0, first), part(1, first + 1)]
    }

    fn order(&self) -> &[u32] {
        &self.primitive_indices
    }
}

impl Built for CwBvh {
    fn parts(&self, node: usize) -> Vec<Part> {
        let source = &self.nodes[node];
        let present = (0..8).filter(|&at| !source.is_child_empty(at));
        let part = |at: usize| {
            let bounds = source.child_aabb(at);
            // The stored planes are exact multiples of a power of two from the node's corner, but their sum in f32 is
            // rounded: one step outwards makes up for it.
            let low = Vec3::from(bounds.min).to_array().map(f32::next_down).into();
            let high = Vec3::from(bounds.max).to_array().map(f32::next_up).into();
            let child = if source.is_leaf(at) {
                let (start, count) = source.child_primitives(at);
                PartChild::Leaf { start, count }
            } else {
                PartChild::Node(source.child_node_index(at) as usize)
            };
            Part { at, low, high, child }
        };
        present.map(part).collect()
    }

    fn order(&self) -> &[u32] {
        &self.primitive_indices
    }
}

fn lay_out<const N: usize>(built: &impl Built, items: &[Item<'_>], base: Base) -> Tree<N> {
    let mut tree = Tree { nodes: Vec::new(), records: Vec::with_capacity(items.len()) };
    // Nodes to lay out, each with its parent's place and its own place among the children; the first child on top, so
    // that it follows its parent in memory.
    let mut waiting: Vec<(usize, Option<(usize, usize)>)> = vec![(0, None)];
    while let Some((node, parent)) = waiting.pop() {
        let place = tree.nodes.len();
        tree.nodes.push(Node::default());
        if let Some((parent, at)) = parent {
            tree.nodes[parent].children[at] = Child { index: base.node + place as u32, count: 0 };
        }
        let first_waiting = waiting.len();
        for Part { at, low, high, child } in built.parts(node) {
            let child = match child {
                PartChild::Leaf { start, count } => {
                    let slot = base.slot + tree.records.len() as u32;
                    let run = &built.order()[start as usize..(start + count) as usize];
                    let records = run.iter().map(|&index| items[index as usize]);
                    tree.records.extend(records.map(|item| Record::new(item.triangle, item.primitive)));
                    Child { index: slot, count }
                }
                PartChild::Node(node) => {
                    waiting.push((node, Some((place, at))));
                    Child::NONE
                }
            };
            tree.nodes[place].set(at, child, low, high);
        }
        waiting[first_waiting..].reverse();
    }
    tree
}
