//! A static tree of boxes and a dynamic one under one root.

use super::ancestry::Ancestry;
use super::packed::{Packed, Wide};
use super::tree::Tree;
use crate::accel::ray::Boxes;

/// The static tree and the dynamic one under one root.
pub(crate) struct Forest<'a, const N: usize>
where
    Tree<N>: Wide<N>,
{
    /// Boxes of the static tree and the dynamic one, where node 0 joins the two; without dynamic triangles node 0 is
    /// the static tree's own.
    pub boxes: Boxes<8>,
    /// Whether the root joins two trees.
    pub joined: bool,
    /// Nodes and records with ids from 0 on.
    pub statics: &'a Tree<N>,
    /// The static tree as rays walk it.
    pub packed: &'a Packed<<Tree<N> as Wide<N>>::Node>,
    /// Parents of the static nodes.
    pub ancestry: &'a Ancestry,
    /// Nodes and records with ids after the static ones.
    pub dynamic: Tree<N>,
    /// The dynamic tree as rays walk it.
    pub packed_dynamic: Packed<<Tree<N> as Wide<N>>::Node>,
}
