//! Lower bound of a ray's latency: no contention, and every missed line arrives one cycle after its access.

use crate::machine::MachineSpec;
use crate::memory::cache::CacheSpec;
use crate::memory::tags::Contents;
use crate::stats::LatencyCounts;
use crate::stream::{Decision, RayKind, Step, Stop};

/// The least latencies of a machine's parts, in cycles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unloaded {
    dispatch: u64,
    node: u64,
    list: u64,
    test: u64,
    division: u64,
}

impl Unloaded {
    /// The least latencies of `machine`.
    pub(super) fn new(machine: &MachineSpec) -> Self {
        // An MSHR hit may get its line in the cycle after the access, sooner than a hit; an ideal cache has hits only.
        let access = |cache: &CacheSpec| match cache.contents {
            Contents::Tags => 1,
            Contents::Ideal => cache.latency.get(),
        };
        let MachineSpec { dispatcher, traversal, list, intersection, division, .. } = machine;
        Self {
            dispatch: dispatcher.latency.get(),
            node: access(&traversal.cache) + traversal.latency.get(),
            list: access(&list.cache) + list.latency.get(),
            test: access(&intersection.cache) + intersection.latency.get(),
            division: 1 + division.latency.get(),
        }
    }

    /// The least latency of each path step of a ray of kind `ray`, by the step's tag.
    pub(super) fn by_tag(&self, ray: RayKind) -> [u64; Step::TAGS] {
        std::array::from_fn(|tag| Step::of_tag(tag).map_or(0, |step| self.step(step, ray)))
    }

    /// The least latency from hand-over to the traversal unit.
    pub(super) fn dispatch(&self) -> u64 {
        self.dispatch
    }

    /// The least latency of a path step of a ray of kind `ray`.
    pub(super) fn step(&self, step: Step, ray: RayKind) -> u64 {
        match step {
            Step::Node(_) => self.node,
            // The way to the list unit is part of the test before, or is not counted.
            Step::List(_) => self.list,
            Step::Triangle { stop, .. } => {
                let there_and_back = 2;
                let divides = stop == Stop::Hit && ray != RayKind::Shadow;
                let division = if divides { self.division } else { 0 };
                there_and_back + self.test * if stop == Stop::Plane { 1 } else { 2 } + division
            }
            Step::Read { .. } | Step::Write { .. } | Step::Update { .. } => 0,
        }
    }
}

/// Latencies of rays by kind, in the order of [`RayKind::ALL`], and the number of rays below their lower bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct RayLatencies {
    /// By kind.
    pub kinds: [LatencyCounts; RayKind::ALL.len()],
    /// Rays that took less than [`Unloaded`] allows: an error in the simulator.
    pub too_fast: u64,
}

impl RayLatencies {
    /// Counts a ray that took `cycles` from hand-over to its end. A skipped ray has no path and is not counted.
    pub(super) fn count(&mut self, kind: RayKind, decision: Decision, cycles: u64, unloaded: u64) {
        if decision == Decision::Skip {
            return;
        }
        let counts = &mut self.kinds[kind as usize];
        counts.rays += 1;
        counts.cycles += cycles;
        counts.unloaded += unloaded;
        counts.most = counts.most.max(cycles);
        self.too_fast += u64::from(cycles < unloaded);
    }

    /// Resets the longest latencies, which then hold for later rays only.
    pub(super) fn forget_longest(&mut self) {
        self.kinds.iter_mut().for_each(|counts| counts.most = 0);
    }
}
