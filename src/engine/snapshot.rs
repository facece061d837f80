//! State of a machine's parts at the end of a cycle, in the order of [`Places`].

use super::tally::{PerCause, QueueKind, Tally};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::stats::Cause;

/// State of a machine's parts at the end of a cycle.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Snapshot {
    /// Cycles by cause since the run began: the dispatcher's, then the units' kind by kind, division units last.
    pub causes: Vec<PerCause>,
    /// Number of entries in each queue, kind by kind as in [`QueueKind::ALL`].
    pub queues: Vec<u32>,
    /// Number of misses under way in each cache: L1s kind by kind, then banks of the L2.
    pub misses: Vec<u32>,
}

impl Snapshot {
    /// The causes in a tally, without queues and misses.
    pub(super) fn of(tally: &Tally) -> Self {
        let units = tally.units.iter().flatten().map(|unit| unit.causes);
        let causes = std::iter::once(tally.dispatcher).chain(units).chain(tally.divisions.iter().copied());
        Self { causes: causes.collect(), ..Self::default() }
    }

    /// For each unit, the cause of the one cycle between `earlier` and this snapshot; overwrites `states`.
    ///
    /// # Errors
    /// A unit has no cause or several for the cycle: an error in the simulator.
    pub(super) fn causes_since(&self, earlier: &Self, states: &mut Vec<Cause>) -> Result<(), String> {
        states.clear();
        for (unit, (now, before)) in self.causes.iter().zip(&earlier.causes).enumerate() {
            let mut passed = Cause::ALL.into_iter().filter(|&cause| now[cause as usize] != before[cause as usize]);
            match (passed.next(), passed.next()) {
                (Some(cause), None) if now[cause as usize] == before[cause as usize] + 1 => states.push(cause),
                _ => return Err(format!("unit {unit} has no single cause in a cycle: {before:?}, then {now:?}")),
            }
        }
        Ok(())
    }
}

/// A part of a machine: its kind, and its index among the parts of this kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The kind, as named in reports.
    pub kind: String,
    /// The index.
    pub index: u32,
}

/// The parts that a snapshot describes, in its order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// Units, the dispatcher first.
    pub units: Vec<Place>,
    /// Queues, named by the part that takes from them.
    pub queues: Vec<Place>,
    /// Caches whose misses under way are counted.
    pub misses: Vec<Place>,
}

impl Places {
    /// The parts of `machine`.
    pub fn of(machine: &MachineSpec) -> Self {
        let cores = machine.cores.get();
        let count = |kind: Kind| match kind {
            Kind::Traversal => machine.traversal.count.get(),
            Kind::List => machine.list.count.get(),
            Kind::Intersection => machine.intersection.count.get(),
            Kind::ShadowCache => machine.shadow_cache.count.get(),
        };
        let all = |kind: &str, count: u64| {
            let kind = kind.to_owned();
            (0..count as u32).map(move |index| Place { kind: kind.clone(), index })
        };
        let (division, channels) = (cores * machine.division.count.get(), machine.dram.channels.get());
        let banks = cores * machine.l2.banks();
        let kinds = || Kind::ALL.into_iter();
        let of_queue = |queue: QueueKind| match queue {
            QueueKind::Dispatcher | QueueKind::Host => 1,
            QueueKind::List => cores * count(Kind::List),
            QueueKind::Intersection => cores * count(Kind::Intersection),
            QueueKind::Division => division,
            QueueKind::L2 => banks,
            QueueKind::Dram => channels,
        };
        Self {
            units: all("dispatcher", 1)
                .chain(kinds().flat_map(|kind| all(kind.names().0, cores * count(kind))))
                .chain(all("division", division))
                .collect(),
            queues: QueueKind::ALL.into_iter().flat_map(|kind| all(kind.name(), of_queue(kind))).collect(),
            misses: kinds().flat_map(|kind| all(kind.names().1, cores * count(kind))).chain(all("l2", banks)).collect(),
        }
    }
}
