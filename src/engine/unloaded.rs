//! What a ray takes at least: as if it were alone, and every line about to come.

use crate::machine::MachineSpec;
use crate::memory::cache::CacheSpec;
use crate::memory::tags::Contents;
use crate::stats::LatencyCounts;
use crate::stream::{Decision, RayKind, Step, Stop};

/// The least latencies of a machine, in cycles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unloaded {
    dispatch: u64,
    node: u64,
    list: u64,
    test: u64,
    division: u64,
}

impl Unloaded {
    /// Of `machine`.
    pub(super) fn new(machine: &MachineSpec) -> Self {
        // A line that a miss asked for earlier may come in the cycle after an access to it; a hit takes its time.
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

    /// The steps of the path of a ray of a kind, by their tags.
    pub(super) fn by_tag(&self, ray: RayKind) -> [u64; Step::TAGS] {
        std::array::from_fn(|tag| Step::of_tag(tag).map_or(0, |step| self.step(step, ray)))
    }

    /// From being handed over to the traversal unit.
    pub(super) fn dispatch(&self) -> u64 {
        self.dispatch
    }

    /// A step of the path of a ray of a kind.
    pub(super) fn step(&self, step: Step, ray: RayKind) -> u64 {
        match step {
            Step::Node(_) => self.node,
            // The way to the list unit is that of the test before, or one that is not counted.
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

/// Latencies of all kinds of rays, in the order of [`RayKind::ALL`], and how many were shorter than they can be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct RayLatencies {
    /// By kind.
    pub kinds: [LatencyCounts; RayKind::ALL.len()],
    /// Rays that took less than [`Unloaded`] says: an error in the simulator.
    pub too_fast: u64,
}

impl RayLatencies {
    /// Counts a ray that took `cycles` from being handed over to being done; one that was skipped has no path to take.
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

    /// From now on the longest latencies are those of rays to come.
    pub(super) fn forget_longest(&mut self) {
        self.kinds.iter_mut().for_each(|counts| counts.most = 0);
    }
}
