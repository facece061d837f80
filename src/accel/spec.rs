//! Which structure is built: settings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ranged::Within;
use crate::stream::Structure;

/// The acceleration structure, and the quality of its build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AccelSpec {
    /// The kind of acceleration structure.
    pub structure: Structure,
    /// Build quality of the static tree.
    pub statics: Quality,
    /// Build quality of the dynamic tree, which is built in each frame.
    pub dynamic: Quality,
    /// The order of a kd-tree's nodes in memory. The other structures have a single order.
    pub kd_layout: KdLayout,
    /// Entries of a ray's stack in a kd-tree. A full stack drops its deepest entry; a ray that needs this entry walks
    /// down the tree again. Unlimited if not given.
    pub kd_stack: Option<Within<1, 64>>,
    /// Maximum depth of a kd-tree. If not given, it follows from the number of triangles.
    pub kd_depth: Option<Within<1, 64>>,
    /// A cell of a kd-tree with at most this many triangles is not split. If not given, the cost model alone decides.
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

/// Build quality. For BVHs: presets of obvhs without pre-splits, so that each triangle has one record. For kd-trees:
/// how exactly triangles are cut at planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Quality {
    /// A fast build, for trees that live one frame.
    Fast,
    /// Quality and effort between `Fast` and `Best`.
    Medium,
    /// The best quality. For more than 400,000 triangles, only the upper part of the tree has this quality.
    Best,
}

/// The order of a kd-tree's nodes in memory. Both are depth-first: a child follows its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum KdLayout {
    /// The left child follows its parent.
    DepthFirst,
    /// The child with the larger surface follows its parent, since more rays visit it; one bit of the node names the
    /// child. The "ordered depth-first layout" (Nah et al. 2010), which the T&I engine
    /// uses (Nah et al. 2011).
    Ordered,
}
