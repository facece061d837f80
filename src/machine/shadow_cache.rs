//! The spec of the shadow-cache units: where a policy's stores lie, and the path of accesses to them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::stores::StoreLayout;
use super::word_traffic::{Decide, LatchedCopy, SilentUpdates};
use super::writes::WritePolicy;
use crate::memory::cache::CacheSpec;
use crate::ranged::{Size, Within};
use crate::stream::{Ray, Step};

/// The path of accesses to a policy's stores: mode words, counters and occluder ids.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Place {
    /// Through the unit's own L1.
    #[default]
    Own,
    /// Through the L1s of the intersection units, where they compete with triangle records.
    Triangle,
    /// Bypass: to the L2, without an L1.
    L2,
    /// Free words: accesses cost no time, access or memory. Costs are measured against this limit.
    Free,
}

/// The end-of-frame update of mode words and counters, for policies that keep counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FrameEnd {
    /// Updates the entries that the frame touched: the recorded steps.
    #[default]
    List,
    /// Updates all entries.
    Sweep,
    /// No end-of-frame update: the first touch of an entry in a later frame updates it.
    Epoch,
}

/// Shadow-cache units.
///
/// Source: assumed, as no such hardware is published; sized like the T&I engine's list unit (4 KB of 2 ways).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ShadowCacheSpec {
    /// Units per core.
    pub count: Within<1, 64>,
    /// Stages of the pipeline.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Cycles from the start of an operation to the start of the next one.
    #[schemars(extend("unit" = "cycles"))]
    pub interval: Within<1, 1000>,
    /// Contexts of a unit: the rays it works on at once.
    pub contexts: Within<1, 4096>,
    /// Rays that a unit takes per cycle, and operations that begin per cycle. With several units (`count`), each owns
    /// the mode words of some lines; a single wide unit owns all of them.
    pub width: Within<1, 64>,
    /// Which updates of mode words are sent to the unit. All others are dropped at the ray.
    pub silent: SilentUpdates,
    /// Where decisions on shadow rays are made.
    pub decide: Decide,
    /// Entries per core of a table that gathers a hit's updates of mode words and sends them once; 0 for no table. A
    /// hit with several lights updates the same word several times. The table, beside the dispatcher, holds the updates
    /// until the hit's last traced shadow ray is done.
    pub gather: Within<0, 65_536>,
    /// How latched words and newly learned bits are stored separately.
    pub latched: LatchedCopy,
    /// Which way accesses to stores go.
    pub place: Place,
    /// The layout of stores in memory.
    pub layout: StoreLayout,
    /// The write policy for stores.
    pub writes: WritePolicy,
    /// Entries of the coalescing register in front of a unit; 0 for none.
    pub register: Within<0, 64>,
    /// The end-of-frame update of mode words and counters.
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
