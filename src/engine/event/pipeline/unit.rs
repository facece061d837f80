//! The common part of a unit: its state and its counts.

use super::super::causes::Causes;
use super::super::memory::Memory;
use super::super::ray::RayId;
use crate::machine::writes::WritePolicy;
use crate::memory::cache::{BanksInUse, BypassCounts, Cache, CacheSpec, Release};
use crate::memory::ring::Ring;
use crate::memory::tags::TagArray;
use crate::memory::{PartId, Request};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{L1Counts, TrafficClass};

/// The timing of a unit's pipeline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stages {
    /// Cycles from the beginning of an operation to its end.
    pub latency: u64,
    /// Cycles from the beginning of an operation to the beginning of the next.
    pub interval: u64,
    /// Operations that can begin in one cycle.
    pub width: u64,
}

/// The common part of a unit. The unit calls [`Pipeline::arrive`], [`Pipeline::leave`], [`Pipeline::begin`] and
/// [`Pipeline::end`] in this order, once in every cycle in which it acts.
#[derive(Clone, Debug)]
pub(crate) struct Pipeline {
    pub(super) part: PartId,
    pub(super) core: u32,
    pub(super) cache: Cache,
    /// Requests to the L2, each with the cycle in which it is made.
    pub(super) out: Ring<(u64, Request)>,
    pub(super) out_places: usize,
    pub(super) ports: u64,
    pub(super) banks: BanksInUse,
    pub(super) hit_latency: u64,
    pub(super) timing: Stages,
    /// The first cycle in which an operation can begin.
    pub(super) open_at: u64,
    pub(super) line: Bytes,
    pub(super) writes: WritePolicy,
    pub(super) fetching: Ring<RayId>,
    pub(super) hits: Ring<(u64, RayId)>,
    /// Number of rays that have made all their accesses and wait for lines.
    pub(super) waiting: usize,
    pub(super) ready: Ring<RayId>,
    /// Rays in the pipeline, each with its operation's end cycle; an operation entered ahead begins in a later cycle.
    pub(super) stages: Ring<(u64, RayId)>,
    pub(super) requested: [Bytes; TrafficClass::ALL.len()],
    pub(super) written_through: [BypassCounts; TrafficClass::ALL.len()],
    pub(super) causes: Causes,
    /// Number of operations that began in a cycle beside its first one.
    pub(super) beside: u64,
    pub(super) filled: bool,
    /// Whether the first ray of the fetch queue found no register, target or place: it finds none until a line arrives
    /// or a request is sent.
    pub(super) stuck: bool,
    /// Whether a line was accessed in this cycle. The access may have made a clean line the next victim, or made room
    /// for the line that waits: a waiting fill may then succeed.
    pub(super) accessed: bool,
    /// Whether hits are foreseen ([`Pipeline::foresee`]), and the shortest latency of the L2.
    pub(super) foresees: bool,
    pub(super) answer_latency: u64,
    /// The first cycle in which a line can be put in.
    pub(super) fill_at: u64,
    /// The first cycle in which the port of the L1 is free.
    pub(super) access_at: u64,
    /// The cycle in which the last operation entered ahead begins.
    pub(super) begins_last: u64,
    pub(super) filled_for: Vec<RayId>,
    pub(super) release: Release,
    /// Rays that get an arrived line one by one ([`Release::OneByOne`]), and the cycle in which the next ray gets it.
    pub(super) released: Ring<RayId>,
    pub(super) release_at: u64,
    /// Requests under way that bypass the L1, the oldest first, and their greatest number.
    pub(super) bypassing: Ring<(LineAddr, RayId)>,
    pub(super) most_bypassing: usize,
    pub(super) bypassed: [BypassCounts; TrafficClass::ALL.len()],
    /// Misses of attributed rays.
    pub(super) attributed: [u64; TrafficClass::ALL.len()],
}

impl Pipeline {
    /// An empty unit, part `part` of core `core`.
    pub(crate) fn new(
        part: PartId,
        core: u32,
        cache: &CacheSpec,
        timing: Stages,
        writes: WritePolicy,
        memory: Memory,
    ) -> Self {
        let Memory { line, answer_latency } = memory;
        let one_a_cycle = cache.ports.get() == 1 && timing.interval == 1 && timing.width == 1;
        let foresees = one_a_cycle && writes == WritePolicy::Back;
        Self {
            part,
            core,
            cache: cache.build(line),
            out: Ring::new(),
            out_places: cache.queue.size(),
            ports: cache.ports.get(),
            banks: BanksInUse::none(cache),
            hit_latency: cache.latency.get(),
            timing,
            open_at: 0,
            line: Bytes(line),
            writes,
            fetching: Ring::new(),
            hits: Ring::new(),
            waiting: 0,
            ready: Ring::new(),
            stages: Ring::new(),
            requested: [Bytes(0); TrafficClass::ALL.len()],
            written_through: [BypassCounts::default(); TrafficClass::ALL.len()],
            causes: Causes::default(),
            beside: 0,
            filled: false,
            stuck: false,
            accessed: false,
            foresees,
            answer_latency,
            fill_at: 0,
            access_at: 0,
            begins_last: 0,
            filled_for: Vec::new(),
            release: cache.release,
            released: Ring::new(),
            release_at: 0,
            bypassing: Ring::new(),
            most_bypassing: cache.mshrs.size(),
            bypassed: [BypassCounts::default(); TrafficClass::ALL.len()],
            attributed: [0; TrafficClass::ALL.len()],
        }
    }

    /// The unit's number in the machine.
    #[inline]
    pub(crate) fn part(&self) -> PartId {
        self.part
    }

    /// The unit's core.
    #[inline]
    pub(crate) fn core(&self) -> u32 {
        self.core
    }

    /// A frame begins: the L1 drops lines from `first` on.
    pub(crate) fn drop_from(&mut self, first: LineAddr) {
        self.cache.drop_from(first);
    }

    /// Loads the contents of `tags` into the L1.
    pub(crate) fn hold(&mut self, tags: &TagArray) {
        self.stuck = false;
        self.cache.hold(tags);
    }

    /// Whether no request to the L2 waits or is under way.
    pub(crate) fn is_idle(&self) -> bool {
        self.out.is_empty() && self.cache.misses_under_way() == 0 && self.bypassing.is_empty()
    }

    /// The L1.
    pub(crate) fn cache(&self) -> &Cache {
        &self.cache
    }

    /// Bytes that the unit requested from its L1, by class.
    pub(crate) fn requested(&self) -> &[Bytes; TrafficClass::ALL.len()] {
        &self.requested
    }

    /// Writes that went through the L1, by class.
    pub(crate) fn written_through(&self) -> &[BypassCounts; TrafficClass::ALL.len()] {
        &self.written_through
    }

    /// Reads that bypassed the L1, by class.
    pub(crate) fn bypassed(&self) -> &[BypassCounts; TrafficClass::ALL.len()] {
        &self.bypassed
    }

    /// Counts that only an L1 has, by class.
    pub(crate) fn l1_counts(&self) -> &[L1Counts; TrafficClass::ALL.len()] {
        self.banks.counts()
    }

    /// Misses of attributed rays, by class.
    pub(crate) fn attributed(&self) -> &[u64; TrafficClass::ALL.len()] {
        &self.attributed
    }

    /// The unit's cycles.
    pub(crate) fn causes(&self) -> &Causes {
        &self.causes
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self) -> String {
        format!(
            "to fetch {}, waiting for lines {}, ready {}, in the pipeline {}, misses under way {}, out {}/{}",
            self.fetching.len(),
            self.waiting,
            self.ready.len(),
            self.stages.len(),
            self.cache.misses_under_way(),
            self.out.len(),
            self.out_places
        )
    }
}
