//! A static and a dynamic tree of boxes under one root.

use super::ancestry::Ancestry;
use super::packed::{Packed, Wide};
use super::tree::Tree;
use crate::accel::ray::Boxes;

/// The static and the dynamic tree under one root.
pub(crate) struct Forest<'a, const N: usize>
where
    Tree<N>: Wide<N>,
{
    /// Boxes of the static and the dynamic tree, if node 0 joins the two. Without dynamic triangles, node 0 is the
    /// static tree's root.
    pub boxes: Boxes<8>,
    /// Whether the root joins two trees.
    pub joined: bool,
    /// The static tree, with ids from 0 on.
    pub statics: &'a Tree<N>,
    /// The static tree in the layout that rays walk.
    pub packed: &'a Packed<<Tree<N> as Wide<N>>::Node>,
    /// Parents of the static nodes.
    pub ancestry: &'a Ancestry,
    /// The dynamic tree, with ids after the static ones.
    pub dynamic: Tree<N>,
    /// The dynamic tree in the layout that rays walk.
    pub packed_dynamic: Packed<<Tree<N> as Wide<N>>::Node>,
}
