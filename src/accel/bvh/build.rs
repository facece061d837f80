//! Builds the trees with obvhs, and lays them out: depth-first nodes, triangle records in leaf order.
//!
//! obvhs only builds: its own traversal hides the nodes that it visits, and its CwBVH node test clamps the near end of
//! a ray to a fixed 1e-4.

use std::ops::Range;
use std::time::Duration;

use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::{BvhBuildParams, triangle::Triangle as BuildTriangle};

use super::copies;
use super::tree::{Child, Node, Tree};
use crate::accel::spec::Quality;
use crate::accel::structure::{Base, Item};
use crate::accel::triangle::Record;

/// Number of triangles up to which the best tree tries other places for all nodes (reinsertion, Meister and Bittner
/// 2017). A larger tree tries the same number of nodes, the uppermost. For three million triangles, all nodes take
/// four minutes instead of ten seconds; for a million, all nodes save rays at most a tenth of their steps
/// (docs/decisions).
const ALL_REINSERTED: usize = 400_000;

/// The parameters of obvhs for a tree of this quality over this many triangles.
pub(super) fn params(quality: Quality, triangles: usize) -> BvhBuildParams {
    let preset = match quality {
        Quality::Fast => BvhBuildParams::fast_build(),
        Quality::Medium => BvhBuildParams::medium_build(),
        Quality::Best => BvhBuildParams::very_slow_build(),
    };
    let most = ALL_REINSERTED as f32 / triangles.max(1) as f32;
    let reinsertion_batch_ratio = preset.reinsertion_batch_ratio.min(most);
    BvhBuildParams { pre_split: false, reinsertion_batch_ratio, ..preset }
}

/// A node width that obvhs can build.
pub(crate) trait Build: Sized {
    /// Builds the tree over `items`, which must not be empty.
    fn build(items: &[Item<'_>], params: BvhBuildParams, base: Base) -> Self;
}

impl Build for Tree<2> {
    fn build(items: &[Item<'_>], params: BvhBuildParams, base: Base) -> Self {
        let mut build_time = Duration::ZERO;
        over_groups(items, base, |corners| build_bvh2_from_tris(corners, params, &mut build_time))
    }
}

impl Build for Tree<8> {
    fn build(items: &[Item<'_>], params: BvhBuildParams, base: Base) -> Self {
        let mut build_time = Duration::ZERO;
        over_groups(items, base, |corners| build_cwbvh_from_tris(corners, params, &mut build_time))
    }
}

/// Builds over one item of each group of equal boxes, and lays out all items.
fn over_groups<const N: usize, B: Built>(
    items: &[Item<'_>],
    base: Base,
    build: impl FnOnce(&[BuildTriangle]) -> B,
) -> Tree<N> {
    let corners = |item: &Item<'_>| {
        let [v0, v1, v2] = item.triangle.v.map(Into::into);
        BuildTriangle { v0, v1, v2 }
    };
    match copies::groups(items) {
        None => {
            let built = build(&items.iter().map(corners).collect::<Vec<_>>());
            let order = built.order().to_vec();
            lay_out(&built, items, &order, |leaf| leaf, base)
        }
        Some(groups) => {
            let firsts: Vec<_> = groups.iter().map(|group| corners(&items[group[0] as usize])).collect();
            let built = build(&firsts);
            // Start of each group in `order`, by the group's place in the built order.
            let mut starts = vec![0];
            let mut order = Vec::with_capacity(items.len());
            for &group in built.order() {
                order.extend_from_slice(&groups[group as usize]);
                starts.push(order.len());
            }
            lay_out(&built, items, &order, |leaf| starts[leaf.start]..starts[leaf.end], base)
        }
    }
}

/// A child of a built node, with its box.
struct Part {
    at: usize,
    low: Vec3,
    high: Vec3,
    child: PartChild,
}

enum PartChild {
    /// A node to be laid out.
    Node(Open),
    /// A range of the items in leaf order.
    Leaf(Range<usize>),
}

/// The parts of an obvhs tree that the layout reads; node 0 is the root.
trait Built {
    /// The children of a node; a leaf is a range of the built order.
    fn parts(&self, node: usize) -> Vec<Part>;
    /// The primitives in leaf order.
    fn order(&self) -> &[u32];
}

impl Built for Bvh2 {
    fn parts(&self, node: usize) -> Vec<Part> {
        let part = |at: usize, node: usize| {
            let source = &self.nodes[node];
            let child = if source.is_leaf() {
                let start = source.first_index as usize;
                PartChild::Leaf(start..start + source.prim_count as usize)
            } else {
                PartChild::Node(Open::Built(node))
            };
            Part { at, low: source.aabb().min.into(), high: source.aabb().max.into(), child }
        };
        if self.nodes[node].is_leaf() {
            // Only in a tree that is one leaf: this leaf becomes the only child of the root.
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
            // The stored planes are exact multiples of a power of two from the node's corner, but their sum is rounded
            // to `f32`. One step outwards covers this error.
            let low = Vec3::from(bounds.min).to_array().map(f32::next_down).into();
            let high = Vec3::from(bounds.max).to_array().map(f32::next_up).into();
            let child = if source.is_leaf(at) {
                let (start, count) = source.child_primitives(at);
                PartChild::Leaf(start as usize..(start + count) as usize)
            } else {
                PartChild::Node(Open::Built(source.child_node_index(at) as usize))
            };
            Part { at, low, high, child }
        };
        present.map(part).collect()
    }

    fn order(&self) -> &[u32] {
        &self.primitive_indices
    }
}

/// A node that is still to be laid out.
enum Open {
    /// A node that obvhs built.
    Built(usize),
    /// A range of items with the same box, too many for a leaf.
    Run(Range<usize>, Vec3, Vec3),
}

/// Maximum number of items in a leaf that is cut from a run: the maximum of a CwBVH leaf.
const RUN_LEAF: usize = 3;

/// Lays out a built tree. `order` lists all items in leaf order; `members` maps a leaf's range of the built order to
/// its range of `order`.
fn lay_out<const N: usize>(
    built: &impl Built,
    items: &[Item<'_>],
    order: &[u32],
    members: impl Fn(Range<usize>) -> Range<usize>,
    base: Base,
) -> Tree<N> {
    let mut tree = Tree { nodes: Vec::new(), records: Vec::with_capacity(items.len()) };
    // Nodes to lay out, each with its parent's place and its index among the children. The first child is on top, so
    // that it follows its parent in memory.
    let mut waiting: Vec<(Open, Option<(usize, usize)>)> = vec![(Open::Built(0), None)];
    while let Some((node, parent)) = waiting.pop() {
        let place = tree.nodes.len();
        tree.nodes.push(Node::default());
        if let Some((parent, at)) = parent {
            tree.nodes[parent].children[at] = Child { index: base.node + place as u32, count: 0 };
        }
        let first_waiting = waiting.len();
        let parts = match node {
            Open::Built(node) => built.parts(node).into_iter().map(|part| with_members(part, &members)).collect(),
            Open::Run(run, low, high) => run_parts::<N>(run, low, high),
        };
        for Part { at, low, high, child } in parts {
            let child = match child {
                PartChild::Leaf(leaf) => {
                    let slot = base.slot + tree.records.len() as u32;
                    let records = order[leaf.clone()].iter().map(|&index| items[index as usize]);
                    tree.records.extend(records.map(|item| Record::new(item.triangle, item.primitive)));
                    Child { index: slot, count: leaf.len() as u32 }
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

/// A part of a built node, with its leaf extended to all members of its groups.
fn with_members(part: Part, members: &impl Fn(Range<usize>) -> Range<usize>) -> Part {
    let Part { low, high, .. } = part;
    let child = match part.child {
        PartChild::Leaf(leaf) => {
            let (built, all) = (leaf.len(), members(leaf));
            if all.len() == built { PartChild::Leaf(all) } else { PartChild::Node(Open::Run(all, low, high)) }
        }
        node => node,
    };
    Part { child, ..part }
}

/// The children of a run: ranges of even length, all with the run's box.
fn run_parts<const N: usize>(run: Range<usize>, low: Vec3, high: Vec3) -> Vec<Part> {
    let length = run.len().div_ceil(N);
    let starts = run.clone().step_by(length).enumerate();
    let part = |(at, start): (usize, usize)| {
        let part = start..(start + length).min(run.end);
        let child = if length > RUN_LEAF { PartChild::Node(Open::Run(part, low, high)) } else { PartChild::Leaf(part) };
        Part { at, low, high, child }
    };
    starts.map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_nodes_of_a_large_tree_are_reinserted_as_of_a_small_one() {
        let tried = |quality, triangles| params(quality, triangles).reinsertion_batch_ratio * triangles as f32;
        assert_eq!(tried(Quality::Best, 100_000), 100_000.0);
        assert_eq!(tried(Quality::Best, 4_000_000), tried(Quality::Best, ALL_REINSERTED));
        assert_eq!(tried(Quality::Fast, 1_000_000), 20_000.0, "a fiftieth is little enough");
    }
}
