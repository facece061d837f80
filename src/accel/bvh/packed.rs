//! Trees in the layout that rays walk: nodes of eight boxes, and leaves of blocks of triangles.
//!
//! A [`Tree`] defines the nodes and the ids that are recorded. A packed tree holds the same content in a form that the
//! processor walks faster.

use glam::Vec3;

use super::stack::Stack;
use super::tree::{Child, Tree};
use crate::accel::block::Block;
use crate::accel::lanes::{First, Processor};
use crate::accel::query::Order;
use crate::accel::ray::Boxes;
use crate::accel::slabs::Slabs;
use crate::accel::structure::Base;
use crate::accel::trail::Observer;

/// The target of a ray: a leaf, given by its first block, or a node, given by its place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Goal(u32);

impl Goal {
    const LEAF: u32 = 1 << 31;

    /// The leaf whose first block is `block`.
    fn leaf(block: usize) -> Self {
        Self(Self::LEAF | block as u32)
    }

    /// The node at `place`.
    pub(super) fn node(place: usize) -> Self {
        Self(place as u32)
    }

    /// The first block of a leaf; `None` for a node.
    #[inline(always)]
    pub(super) fn block(self) -> Option<usize> {
        (self.0 & Self::LEAF != 0).then_some((self.0 & !Self::LEAF) as usize)
    }

    /// The node's place.
    #[inline(always)]
    pub(super) fn place(self) -> usize {
        self.0 as usize
    }
}

/// A packed node, for trees of width `N`.
pub(crate) trait Packing<const N: usize>: Sized {
    /// The entry of the stack for children that wait.
    type Rest: Copy + Default;
    /// An array of stack entries, large enough for most trees.
    type Few: AsMut<[Self::Rest]>;

    /// Packs a node of a tree, and its leaves.
    fn pack(packed: &mut Packed<Self>, tree: &Tree<N>, node: usize) -> Self;

    /// The largest number of stack entries that a node with this many children adds.
    fn rests(children: usize) -> usize;

    /// A stack without heap memory.
    fn few() -> Self::Few;

    /// Visits the node, and perhaps one of its children. Returns the ray's next target, by `order`, and pushes the
    /// rest.
    fn visit<L: Processor>(
        &self,
        lanes: L,
        goal: Goal,
        slabs: &Slabs<L>,
        order: Order,
        stack: &mut Stack<'_, Self::Rest>,
        watch: &mut impl Observer,
    ) -> Option<Goal>;

    /// Takes the next target from the stack, for a ray that ends at `last`.
    fn next<L: First>(lanes: L, nodes: &[Self], stack: &mut Stack<'_, Self::Rest>, last: f32) -> Option<Goal>;
}

/// Maps a tree of width `N` to its packed nodes.
pub(crate) trait Wide<const N: usize> {
    /// The packed node.
    type Node: Packing<N>;
}

/// A packed tree.
pub(crate) struct Packed<P> {
    /// Nodes, in the tree's order.
    pub nodes: Vec<P>,
    /// Triangles, leaf by leaf.
    pub blocks: Vec<Block>,
    /// Number of places that a ray's stack needs.
    pub stack: usize,
    /// Ids of the tree's first node and first slot.
    base: Base,
    /// The first block of each leaf, by the leaf's first record.
    leaves: Vec<u32>,
}

impl<P> Packed<P> {
    /// Packs a tree whose ids start at `base`.
    pub(crate) fn new<const N: usize>(tree: &Tree<N>, base: Base) -> Self
    where
        P: Packing<N>,
    {
        let nodes = Vec::with_capacity(tree.nodes.len());
        let leaves = vec![u32::MAX; tree.records.len()];
        let mut packed = Self { nodes, blocks: Vec::new(), stack: stack_places::<N, P>(tree, base), base, leaves };
        for node in 0..tree.nodes.len() {
            let node = P::pack(&mut packed, tree, node);
            packed.nodes.push(node);
        }
        packed.leaves = Vec::new();
        packed
    }

    /// The id of the tree's node number `node`.
    pub(super) fn id(&self, node: usize) -> u32 {
        self.base.node + node as u32
    }

    /// The index in the tree of the node `id`.
    pub(super) fn local(&self, id: u32) -> usize {
        (id - self.base.node) as usize
    }

    /// The first slot of the tree's records.
    #[inline(always)]
    pub(super) fn first_slot(&self) -> u32 {
        self.base.slot
    }

    /// The target for `child`; packs a leaf that is not packed yet.
    pub(super) fn goal<const N: usize>(&mut self, tree: &Tree<N>, child: Child) -> Goal {
        if child.count == 0 {
            return Goal::node(self.local(child.index));
        }
        let first = (child.index - self.base.slot) as usize;
        if self.leaves[first] == u32::MAX {
            self.leaves[first] = self.blocks.len() as u32;
            self.blocks.extend(Block::of_leaf(&tree.records[first..][..child.count as usize], first as u32));
        }
        Goal::leaf(self.leaves[first] as usize)
    }
}

/// The largest number of entries that a ray's stack holds.
fn stack_places<const N: usize, P: Packing<N>>(tree: &Tree<N>, base: Base) -> usize {
    let mut below = vec![0; tree.nodes.len()];
    // Children come after their parents.
    for (at, node) in tree.nodes.iter().enumerate().rev() {
        let children = || node.children.iter().filter(|child| !child.is_none());
        let nodes = children().filter(|child| child.count == 0);
        let most = nodes.map(|child| below[(child.index - base.node) as usize]).max().unwrap_or(0);
        below[at] = most + P::rests(children().count());
    }
    below.into_iter().max().unwrap_or(0)
}

/// Boxes that no ray meets.
pub(super) const NO_BOXES: Boxes<8> = [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3];

/// Sets the box in `lane` to the given corners.
pub(super) fn set_box(boxes: &mut Boxes<8>, lane: usize, (low, high): (Vec3, Vec3)) {
    for (side, corner) in [low, high].into_iter().enumerate() {
        for (planes, coordinate) in boxes.iter_mut().zip(corner.to_array()) {
            planes[side][lane] = coordinate;
        }
    }
}
