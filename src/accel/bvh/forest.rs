//! A static tree of boxes and a dynamic one under one root.

use super::ancestry::Ancestry;
use super::tree::{Node, Tree};

/// The static tree and the dynamic one under one root.
pub(crate) struct Forest<'a, const N: usize> {
    /// Node 0. With dynamic triangles it joins the two trees (child 0 and child 1); without, it is the static tree's
    /// own.
    pub root: Node<N>,
    /// Whether the root joins two trees.
    pub joined: bool,
    /// Nodes and records with ids from 0 on; node 0 itself is `root`.
    pub statics: &'a Tree<N>,
    /// Parents of the static nodes.
    pub ancestry: &'a Ancestry,
    /// Nodes and records with ids after the static ones.
    pub dynamic: Tree<N>,
}

impl<const N: usize> Forest<'_, N> {
    /// The node `id`, which is not 0.
    pub(crate) fn node(&self, id: u32) -> &Node<N> {
        let id = id as usize;
        self.statics.nodes.get(id).unwrap_or_else(|| &self.dynamic.nodes[id - self.statics.nodes.len()])
    }
}
