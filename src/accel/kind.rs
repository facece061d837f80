//! The kinds of trees that a spec can name.

use super::bvh::{self, Bvh};
use super::kdtree::{self, KdTree};
use super::spec::AccelSpec;
use super::structure::{Item, StaticTree};
use crate::stream::Structure;

/// One value, of a type that depends on the kind of tree.
pub(super) enum Kind<Bvh2, CwBvh, KdTree> {
    /// For binary trees of boxes.
    Bvh2(Bvh2),
    /// For trees with eight boxes per node.
    CwBvh(CwBvh),
    /// For kd-trees.
    KdTree(KdTree),
}

/// A static tree of any kind.
pub(super) type AnyStatic = Kind<Bvh<2>, Bvh<8>, KdTree>;

/// A static tree of any kind and a dynamic tree of the same kind under one root.
pub(super) type AnyJoined<'a> = Kind<bvh::Forest<'a, 2>, bvh::Forest<'a, 8>, kdtree::Forest<'a>>;

/// Evaluates `$call`, with `$tree` bound to the content of the variant.
macro_rules! on {
    ($kind:expr, $tree:ident => $call:expr) => {
        match $kind {
            $crate::accel::kind::Kind::Bvh2($tree) => $call,
            $crate::accel::kind::Kind::CwBvh($tree) => $call,
            $crate::accel::kind::Kind::KdTree($tree) => $call,
        }
    };
}
pub(super) use on;

impl AnyStatic {
    /// Builds the static tree of the kind that `spec` names.
    pub(super) fn build(items: &[Item<'_>], spec: &AccelSpec, joined: bool) -> Self {
        match spec.structure {
            Structure::Bvh2 => Self::Bvh2(StaticTree::build(items, spec, joined)),
            Structure::CwBvh => Self::CwBvh(StaticTree::build(items, spec, joined)),
            Structure::KdTree => Self::KdTree(StaticTree::build(items, spec, joined)),
        }
    }

    /// Builds the dynamic tree of a frame and joins the two.
    pub(super) fn join<'a>(&'a self, items: &[Item<'_>], spec: &AccelSpec) -> AnyJoined<'a> {
        match self {
            Self::Bvh2(tree) => Kind::Bvh2(tree.join(items, spec)),
            Self::CwBvh(tree) => Kind::CwBvh(tree.join(items, spec)),
            Self::KdTree(tree) => Kind::KdTree(tree.join(items, spec)),
        }
    }
}
