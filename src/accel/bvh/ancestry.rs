//! The way up in a tree: the node that holds a triangle's leaf, and the parents of this node.

use super::tree::Tree;
use crate::quantity::{NodeId, TriangleSlot};

/// Parents of the static tree's nodes and leaves.
pub(crate) struct Ancestry {
    /// The parent of each node; the root is its own parent.
    parents: Vec<u32>,
    /// The node that holds each slot's leaf.
    holders: Vec<u32>,
}

impl Ancestry {
    /// The ancestry of a static tree.
    pub(crate) fn of<const N: usize>(tree: &Tree<N>) -> Self {
        let mut parents: Vec<u32> = (0..tree.nodes.len() as u32).collect();
        let mut holders = vec![0; tree.records.len()];
        for (node, content) in (0..).zip(&tree.nodes) {
            for child in content.children.iter().filter(|child| !child.is_none()) {
                let first = child.index as usize;
                if child.count == 0 {
                    parents[first] = node;
                } else {
                    holders[first..first + child.count as usize].fill(node);
                }
            }
        }
        Self { parents, holders }
    }

    /// The node `levels` levels above the leaf of `slot`; at most the root. Level 1 is the node that holds the leaf.
    pub(crate) fn ancestor(&self, slot: TriangleSlot, levels: u32) -> NodeId {
        let holder = self.holders[slot.0 as usize];
        NodeId((1..levels).fold(holder, |node, _| self.parents[node as usize]))
    }
}
