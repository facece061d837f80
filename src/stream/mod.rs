//! The ray stream: what the tracer records and the machine replays. The functional and the timing side meet here only.
//!
//! A stream is a [`Header`], then frames. A frame is a [`FrameInfo`], chunks of rays, and what the culling policy does at
//! the frame's end. Rays come in pixel groups: a primary ray, then all that follows from it, never split over chunks.
//! A ray holds the path of its traversal and, apart, what the policy did on its account; it holds ids, not addresses:
//! the replay lays out memory.

pub mod check;
pub mod chunk;
mod columns;
mod error;
pub mod format;
pub mod inspect;
mod packed;
pub mod reader;
pub mod step;
pub mod writer;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use check::{Checker, Violation};
pub use chunk::{Chunk, Decision, Outcome, Ray, RayHead, RayKind};
pub use error::{Fault, Place, StreamError};
pub use format::FrameEntry;
pub use packed::PackedChunk;
pub use reader::StreamReader;
pub use step::{Step, Stop, Store};
pub use writer::StreamWriter;

use crate::counters::counters;
use crate::quantity::{Resolution, TriangleSlot};

/// What a stream is of; written as text at the start of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// The scene's name.
    pub scene: String,
    /// Numbers of the frames, in order.
    pub frames: Vec<u32>,
    /// Those of the frames that warm caches and words up: they are replayed, and left out of what is measured.
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
    /// Static triangles; dynamic primitives count from here on.
    pub static_primitives: u32,
    /// Static and dynamic triangles.
    pub primitives: u32,
    /// Nodes of the root and the static tree: 0 to one less. Dynamic nodes count from here on.
    pub static_nodes: u32,
    /// Triangle records of the static tree. Dynamic slots count from here on.
    pub static_slots: u32,
    /// Entries of the static tree's primitive lists (0 for a BVH).
    pub static_list_entries: u32,
    /// Sizes of the policy's stores.
    pub stores: StoreEntries,
    /// Hash of the scene and the settings that the stream was traced with.
    pub input_hash: u64,
    /// The triangle record of each static primitive, [`NO_RECORD`] for one that has none: it cannot be seen. (In a file it stands
    /// in the index, not in the header's text.)
    #[serde(skip)]
    pub records: Arc<[TriangleSlot]>,
}

/// Stands for the record of a primitive that has none.
pub const NO_RECORD: TriangleSlot = TriangleSlot(u32::MAX);

/// Entries of each store that a policy keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoreEntries {
    /// Entries of the store of mode words: first `words_per_primitive` for each of the first `word_owners` primitives, then whatever
    /// else the policy keeps there. An entry has 32 bits.
    pub mode_words: u32,
    /// Primitives that have mode words.
    pub word_owners: u32,
    /// Mode words of each of them: one up to 15 lights, another for each further 16.
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

/// Acceleration structures that a stream can be of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Structure {
    /// Binary BVH; a node is the boxes of both its children and two references.
    Bvh2,
    /// Compressed 8-wide BVH (Ylitie et al. 2017).
    CwBvh,
    /// kd-tree; a node is a plane and a reference, or a run of list entries.
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

/// A frame of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameInfo {
    /// The frame's number.
    pub number: u32,
    /// Nodes of this frame's dynamic tree.
    pub dynamic_nodes: u32,
    /// Triangle records of this frame's dynamic tree.
    pub dynamic_slots: u32,
    /// Entries of this frame's dynamic primitive lists.
    pub dynamic_list_entries: u32,
}

counters! {
    /// What the tracer counted while it traced a frame, by counters of its own. [`Totals::count`] derives the same from
    /// the records: the two must be equal. A file holds the counters in this order.
    pub struct Totals {
        primary_rays: "rays", "rays from the camera: one a pixel";
        secondary_rays: "rays", "reflected and refracted rays";
        shadow_rays: "rays", "shadow rays that there are without culling: one a hit and light that asks for it";
        shadow_rays_skipped: "rays", "shadow rays whose answer was known: nothing was traced";
        shadow_rays_dynamic_only: "rays", "shadow rays traced among dynamic triangles only";
        node_visits: "visits", "nodes fetched by primary and secondary rays";
        triangle_tests: "tests", "triangles tested by primary and secondary rays";
        shadow_node_visits: "visits", "nodes fetched by shadow rays";
        shadow_triangle_tests: "tests", "triangles tested by shadow rays";
        list_reads: "reads", "entries of the kd-tree's primitive lists read by any ray or policy";
        policy_triangle_tests: "tests", "triangles tested by the policy itself, occlusion tests included";
        policy_node_visits: "visits", "nodes fetched by the policy itself (shaft queries, searches below a node)";
        policy_reads: "accesses", "reads of the policy's stores: mode words, counters, occluder ids";
        policy_writes: "accesses", "writes of the policy's stores, reads with a write after them included";
    }
}

impl Totals {
    /// Counts a policy's steps.
    pub fn count_policy(&mut self, steps: impl Iterator<Item = Step>) {
        for step in steps {
            match step {
                Step::Node(_) => self.policy_node_visits += 1,
                Step::List(_) => self.list_reads += 1,
                Step::Triangle { .. } => self.policy_triangle_tests += 1,
                Step::Read { .. } => self.policy_reads += 1,
                Step::Write { .. } | Step::Update { .. } => self.policy_writes += 1,
            }
        }
    }

    /// Counts a ray.
    pub fn count(&mut self, ray: &Ray<'_>) {
        let [nodes, lists, triangles] = Step::count_path(ray.packed_path());
        self.list_reads += lists;
        match ray.head.kind {
            RayKind::Primary => self.primary_rays += 1,
            RayKind::Reflection | RayKind::Refraction => self.secondary_rays += 1,
            RayKind::Shadow => {
                self.shadow_rays += 1;
                match ray.head.decision {
                    Decision::Trace => {}
                    Decision::DynamicOnly => self.shadow_rays_dynamic_only += 1,
                    Decision::Skip => self.shadow_rays_skipped += 1,
                }
            }
        }
        if ray.head.kind == RayKind::Shadow {
            self.shadow_node_visits += nodes;
            self.shadow_triangle_tests += triangles;
        } else {
            self.node_visits += nodes;
            self.triangle_tests += triangles;
        }
        self.count_policy(ray.policy());
    }
}

/// A piece of a stream, in order: every frame is a `Frame`, any number of `Rays`, and an `End`.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A frame begins.
    Frame(FrameInfo),
    /// Rays of the frame.
    Rays(std::sync::Arc<Chunk>),
    /// The frame ends.
    End {
        /// What the policy does at the frame's end (its sweep), as encoded [`Step`]s.
        policy: std::sync::Arc<Vec<u32>>,
        /// What the tracer counted in the frame.
        totals: Totals,
    },
}
