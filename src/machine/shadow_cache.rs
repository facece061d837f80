//! The spec of the shadow-cache units: where a policy's stores lie, and the path of accesses to them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::stores::StoreLayout;
use super::word_traffic::{Decide, LatchedCopy, SilentUpdates};
use super::writes::WritePolicy;
use crate::memory::cache::CacheSpec;
use crate::ranged::{Size, Within};
use crate::stream::{Ray, Step};

/// Which way accesses to a policy's stores go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Place {
    /// Through an L1 of the unit.
    #[default]
    Own,
    /// Through the L1s of the intersection units, where they compete with triangles.
    Triangle,
    /// Straight to the L2.
    L2,
    /// Nowhere: they cost nothing. The limit that costs are measured against.
    Free,
}

/// What happens to words and counters at a frame's end, of a policy that keeps counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FrameEnd {
    /// Those that the frame touched are set: the recorded steps.
    #[default]
    List,
    /// All are set.
    Sweep,
    /// None: the first touch in a frame sets them.
    Epoch,
}

/// Shadow-cache units.
///
/// Source: assumed, as no such hardware is published; sized like the T&I engine's list unit (4 KB of 2 ways).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ShadowCacheSpec {
    /// Units a core.
    pub count: Within<1, 64>,
    /// Stages of the pipeline.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Cycles from an operation to the next.
    #[schemars(extend("unit" = "cycles"))]
    pub interval: Within<1, 1000>,
    /// Rays that a unit works on at once.
    pub contexts: Within<1, 4096>,
    /// Rays that a unit takes a cycle, and operations that begin in it. Several units a core (`count`) share the words
    /// among them by lines; a wider one has them all.
    pub width: Within<1, 64>,
    /// Which updates of mode words are sent.
    pub silent: SilentUpdates,
    /// Where decisions fall.
    pub decide: Decide,
    /// Hits of a core whose updates of mode words are gathered and sent once; 0 for none. A hit with several lights
    /// sets bits of one word several times; a table beside the dispatcher holds them until the hit's last traced
    /// shadow ray is done.
    pub gather: Within<0, 65_536>,
    /// How latched words and learned bits are kept apart.
    pub latched: LatchedCopy,
    /// Which way accesses to stores go.
    pub place: Place,
    /// How stores lie in memory.
    pub layout: StoreLayout,
    /// What becomes of writes.
    pub writes: WritePolicy,
    /// Entries of the coalescing register in front of a unit; 0 for none.
    pub register: Within<0, 64>,
    /// What happens at a frame's end.
    pub frame_end: FrameEnd,
    /// The L1 of each unit.
    pub cache: CacheSpec,
}

impl ShadowCacheSpec {
    /// Whether a step that the policy recorded for a ray, packed, is performed. Dropped updates and accesses to entries
    /// that cost nothing are not.
    #[inline]
    pub fn performs(&self, word: u32) -> bool {
        let free = || self.place == Place::Free && Step::unpack(word).and_then(Step::entry).is_some();
        !self.silent.drops(word) && !free()
    }

    /// Whether the host answers a ray: decisions fall with the hit, and none of the ray's steps is performed.
    pub(crate) fn is_answered(&self, ray: &Ray<'_>) -> bool {
        let left = || ray.packed_policy().iter().filter(|&&word| self.performs(word)).count();
        self.decide.answers(ray.head.decision, 0) && self.decide.answers(ray.head.decision, left())
    }

    /// Whether all steps of the policy are performed as recorded, for any stream.
    pub fn performs_all(&self) -> bool {
        self.place != Place::Free && self.silent == SilentUpdates::Sent && self.latched != LatchedCopy::Buffers
    }
}

impl Default for ShadowCacheSpec {
    fn default() -> Self {
        Self {
            count: const { Within::literal(1) },
            latency: const { Within::literal(2) },
            interval: const { Within::literal(1) },
            contexts: const { Within::literal(8) },
            width: const { Within::literal(1) },
            silent: SilentUpdates::Sent,
            decide: Decide::Unit,
            gather: const { Within::literal(0) },
            latched: LatchedCopy::Free,
            place: Place::Own,
            layout: StoreLayout::Dense,
            writes: WritePolicy::Back,
            register: const { Within::literal(0) },
            frame_end: FrameEnd::List,
            cache: const { CacheSpec { bytes: Size::literal(4 << 10), ..CacheSpec::DEFAULT } },
        }
    }
}
