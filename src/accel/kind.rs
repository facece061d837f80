//! The kinds of trees that a spec can name.

use super::bvh::{self, Bvh};
use super::kdtree::{self, KdTree};
use super::spec::AccelSpec;
use super::structure::{Item, StaticTree};
use crate::stream::Structure;

/// One thing for each kind of tree.
pub enum Kind<Bvh2, CwBvh, KdTree> {
    /// Of binary trees of boxes.
    Bvh2(Bvh2),
    /// Of trees of eight boxes a node.
    CwBvh(CwBvh),
    /// Of kd-trees.
    KdTree(KdTree),
}

/// A static tree of any kind.
pub type AnyStatic = Kind<Bvh<2>, Bvh<8>, KdTree>;

/// A static tree of any kind and a dynamic one of the same kind under one root.
pub type AnyJoined<'a> = Kind<bvh::Forest<'a, 2>, bvh::Forest<'a, 8>, kdtree::Forest<'a>>;

/// Evaluates `$call` with `$tree` being what the kind holds.
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
    pub fn build(items: &[Item<'_>], spec: &AccelSpec, joined: bool) -> Self {
        match spec.structure {
            Structure::Bvh2 => Self::Bvh2(StaticTree::build(items, spec, joined)),
            Structure::CwBvh => Self::CwBvh(StaticTree::build(items, spec, joined)),
            Structure::KdTree => Self::KdTree(StaticTree::build(items, spec, joined)),
        }
    }

    /// Builds the dynamic tree of a frame and joins the two.
    pub fn join<'a>(&'a self, items: &[Item<'_>], spec: &AccelSpec) -> AnyJoined<'a> {
        match self {
            Self::Bvh2(tree) => Kind::Bvh2(tree.join(items, spec)),
            Self::CwBvh(tree) => Kind::CwBvh(tree.join(items, spec)),
            Self::KdTree(tree) => Kind::KdTree(tree.join(items, spec)),
        }
    }
}
