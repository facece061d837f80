//! Which structure is built: settings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ranged::Within;
use crate::stream::Structure;

/// Which structure is built, and how well.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AccelSpec {
    /// The kind of tree.
    pub structure: Structure,
    /// How much work goes into the static tree.
    pub statics: Quality,
    /// How much work goes into the dynamic tree, each frame.
    pub dynamic: Quality,
    /// The order of a kd-tree's nodes; the other structures have one order only.
    pub kd_layout: KdLayout,
    /// Entries of a ray's stack in a kd-tree: a full one drops its deepest entry, and the ray goes down again when it
    /// needs that. Without a limit if it is not given.
    pub kd_stack: Option<Within<1, 64>>,
    /// The level at which no cell of a kd-tree is split any more; by the number of triangles if it is not given.
    pub kd_depth: Option<Within<1, 64>>,
    /// Triangles up to which a cell of a kd-tree is not split; by cost alone if it is not given.
    pub kd_leaf: Option<Within<1, 1024>>,
}

impl Default for AccelSpec {
    fn default() -> Self {
        Self {
            structure: Structure::Bvh2,
            statics: Quality::Best,
            dynamic: Quality::Fast,
            kd_layout: KdLayout::Ordered,
            kd_stack: None,
            kd_depth: None,
            kd_leaf: None,
        }
    }
}

/// How well a tree is built. For BVHs, presets of obvhs without pre-splits, so that each triangle has one record; for
/// kd-trees, how exactly triangles are cut at planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Quality {
    /// For trees that live one frame.
    Fast,
    /// A good tree.
    Medium,
    /// The best that there is; of a tree over more than 400,000 triangles only the upper part is as good.
    Best,
}

/// The order of a kd-tree's nodes in memory. Both are depth-first: a child follows its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum KdLayout {
    /// The left child follows.
    DepthFirst,
    /// The child with the larger surface follows, since more rays go there; one bit of the node says which it is. The
    /// "ordered depth-first layout" of the T&I engine (Nah et al. 2011).
    Ordered,
}
