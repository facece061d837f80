//! The header of a stream: scene, frames, structure, sizes.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::step::Store;
use crate::quantity::{Resolution, TriangleSlot};

/// The header of a stream; written as text at the start of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// The scene's name.
    pub scene: String,
    /// Numbers of the frames, in order.
    pub frames: Vec<u32>,
    /// The frames that warm up caches and mode words: they are replayed but not measured.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warmup: Vec<u32>,
    /// The picture's size.
    pub resolution: Resolution,
    /// The culling policy's name in the experiment.
    pub policy: String,
    /// The acceleration structure, and with it the size of its nodes.
    pub structure: Structure,
    /// Lights in the scene.
    pub lights: u32,
    /// Static triangles. Ids of dynamic primitives start at this number.
    pub static_primitives: u32,
    /// Static and dynamic triangles.
    pub primitives: u32,
    /// Nodes of the root and the static tree. Ids of dynamic nodes start at this number.
    pub static_nodes: u32,
    /// Triangle records of the static tree. Dynamic slots start at this number.
    pub static_slots: u32,
    /// Entries of the static tree's primitive lists (0 for a BVH).
    pub static_list_entries: u32,
    /// Sizes of the policy's stores.
    pub stores: StoreEntries,
    /// Whether updates of mode words lack their effect, as in files of version 2.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unjudged_updates: bool,
    /// Hash of the scene and the settings that the stream was traced with.
    pub input_hash: u64,
    /// The triangle record of each static primitive, or [`NO_RECORD`] if the primitive cannot be seen. (A file stores
    /// the records in the index, not in the header's text.)
    #[serde(skip)]
    pub records: Arc<[TriangleSlot]>,
}

/// Marks a primitive that has no triangle record.
pub const NO_RECORD: TriangleSlot = TriangleSlot(u32::MAX);

/// Entries of each store that a policy keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoreEntries {
    /// Entries of the store of mode words, 32 bits each: first `words_per_primitive` for each of the first
    /// `word_owners` primitives, then the policy's other words.
    pub mode_words: u32,
    /// Primitives that have mode words.
    pub word_owners: u32,
    /// Mode words of each such primitive: one up to 15 lights, another for each further 16.
    pub words_per_primitive: u32,
    /// Pairs of pixel counters, one for each of the first primitives.
    pub pixel_counters: u32,
    /// Ids of occluders.
    pub occluder_ids: u32,
}

impl StoreEntries {
    /// Entries of one store.
    pub fn of(&self, store: Store) -> u32 {
        match store {
            Store::ModeWord => self.mode_words,
            Store::PixelCounter => self.pixel_counters,
            Store::OccluderId => self.occluder_ids,
        }
    }
}

/// The kind of acceleration structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum Structure {
    /// Binary BVH. A node holds the boxes of its two children and two references.
    Bvh2,
    /// Compressed 8-wide BVH (Ylitie et al. 2017).
    CwBvh,
    /// kd-tree. A node holds a plane and a reference, or a range of list entries.
    KdTree,
}

impl Structure {
    /// Bytes of a node: 2 boxes of 24 B and 2 references of 8 B for the BVH2; 80 B for the CwBVH (Ylitie et al. 2017,
    /// section 3); 8 B for the kd-tree (Nah et al. 2011).
    pub fn node_bytes(self) -> u64 {
        match self {
            Self::Bvh2 => 64,
            Self::CwBvh => 80,
            Self::KdTree => 8,
        }
    }
}
