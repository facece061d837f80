//! All counts of a run, part by part, as plain data. Engines are compared by these counts, and reports are made of
//! them.

use std::collections::BTreeMap;
use std::ops::AddAssign;

use crate::engine::source::StoreWork;
use crate::engine::unloaded::RayLatencies;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::traffic::{RayBuffer, Run};
use crate::memory::bank::Served;
use crate::memory::cache::BypassCounts;
use crate::memory::queue::Load;
use crate::quantity::{Bytes, Cycle};
use crate::stats::{CacheCounts, CacheStats, Cause, DramCounts, L1Counts, MachineStats, QueueCounts, TrafficClass};
use crate::stream::RayKind;

/// One value per traffic class, in the order of [`TrafficClass::ALL`].
pub(crate) type PerClass<T> = [T; TrafficClass::ALL.len()];
/// Cycles per cause, indexed by the cause's discriminant.
pub(crate) type PerCause = [u64; Cause::ALL.len()];

/// `cycles` busy cycles, and none of any other cause: for an engine that knows busy cycles only.
pub(crate) fn busy(cycles: u64) -> PerCause {
    let mut causes = PerCause::default();
    causes[Cause::Busy as usize] = cycles;
    causes
}

/// Counts of a unit with an L1.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct UnitTally {
    /// Cycles by cause.
    pub causes: PerCause,
    /// Operations that began.
    pub operations: u64,
    /// Accesses to its L1.
    pub cache: PerClass<CacheCounts>,
    /// Further counts, which only an L1 has.
    pub l1: PerClass<L1Counts>,
    /// Bytes that the unit requested from its L1.
    pub requested: PerClass<Bytes>,
    /// Writes that went through the L1 to the L2.
    pub written_through: PerClass<BypassCounts>,
    /// Reads that bypassed the L1.
    pub bypassed: PerClass<BypassCounts>,
    /// Misses of attributed rays, in engines that replay samples.
    pub attributed: PerClass<u64>,
}

/// Counts of a bank of the L2.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct BankTally {
    /// Accesses.
    pub cache: PerClass<CacheCounts>,
    /// Reads served to L1s, and bytes moved between L1s and the bank.
    pub served: Served,
}

/// Counts of a channel of the DRAM.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ChannelTally {
    /// Commands.
    pub counts: DramCounts,
    /// Bytes moved.
    pub moved: PerClass<Bytes>,
    /// Whether a refresh was due in the last cycle and not issued.
    pub refresh_due: bool,
}

/// Lines that the host's port requested from the DRAM.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct PortTally {
    /// Lines read.
    pub reads: PerClass<u64>,
    /// Lines written.
    pub writes: PerClass<u64>,
}

impl PortTally {
    /// Counts the lines of `run`.
    pub(crate) fn count(&mut self, run: &Run) {
        let counts = if run.write { &mut self.writes } else { &mut self.reads };
        counts[run.class as usize] += run.lines;
    }
}

/// Kinds of queues, named by the part that takes from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum QueueKind {
    /// The dispatcher, from the in FIFO.
    Dispatcher,
    /// The host, from the out FIFO.
    Host,
    /// List units.
    List,
    /// Intersection units.
    Intersection,
    /// Division units.
    Division,
    /// Banks of the L2.
    L2,
    /// Channels of the DRAM.
    Dram,
}

impl QueueKind {
    /// All kinds.
    pub(crate) const ALL: [Self; 7] =
        [Self::Dispatcher, Self::Host, Self::List, Self::Intersection, Self::Division, Self::L2, Self::Dram];

    /// The kind's name in reports.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Dispatcher => "in_fifo",
            Self::Host => "out_fifo",
            Self::List => "list",
            Self::Intersection => "intersection",
            Self::Division => "division",
            Self::L2 => "l2",
            Self::Dram => "dram",
        }
    }
}

/// The counts of a whole run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// Cycles that the run took.
    pub cycles: u64,
    /// Whether every cycle of every unit has a cause; if not, only busy cycles are counted.
    pub has_causes: bool,
    /// Rays done, without skipped rays.
    pub rays: u64,
    /// The dispatcher's cycles by cause.
    pub dispatcher: PerCause,
    /// Store steps that were performed otherwise than recorded.
    pub stores: StoreWork,
    /// The load of each queue, by the part that takes from the queue; the FIFOs from and to the host come first.
    pub queues: [Vec<Load>; QueueKind::ALL.len()],
    /// Latencies of rays.
    pub latencies: RayLatencies,
    /// Units, by kind.
    pub units: [Vec<UnitTally>; Kind::ALL.len()],
    /// The division units' cycles by cause.
    pub divisions: Vec<PerCause>,
    /// Banks of the L2s, core by core.
    pub banks: Vec<BankTally>,
    /// The host's port to the DRAM.
    pub port: PortTally,
    /// Channels of the DRAM.
    pub channels: Vec<ChannelTally>,
}

impl Tally {
    /// Busy cycles of all units plus column commands of the DRAM: the progress that the watchdog checks.
    pub(crate) fn operations(&self) -> u64 {
        let busy = |causes: &PerCause| causes[Cause::Busy as usize];
        let columns = |channel: &ChannelTally| channel.counts.reads + channel.counts.writes;
        busy(&self.dispatcher)
            + self.units.iter().flatten().map(|unit| busy(&unit.causes)).sum::<u64>()
            + self.divisions.iter().map(busy).sum::<u64>()
            + self.channels.iter().map(columns).sum::<u64>()
    }

    /// Busy cycles of the units of each kind.
    pub(crate) fn operations_by_kind(&self) -> [u64; Kind::ALL.len()] {
        let busy = |units: &Vec<UnitTally>| units.iter().map(|unit| unit.causes[Cause::Busy as usize]).sum();
        std::array::from_fn(|kind| busy(&self.units[kind]))
    }

    /// The commands of all channels.
    pub(crate) fn commands(&self) -> DramCounts {
        self.channels.iter().map(|channel| channel.counts).sum()
    }

    /// The counts in the form of a report.
    pub(crate) fn stats(&self, machine: &MachineSpec) -> MachineStats {
        let mut stats = MachineStats {
            cycles: Cycle(self.cycles),
            clock_mhz: machine.clock_mhz.get() as f64,
            rays: self.rays,
            dram: self.commands(),
            dram_organization: machine.dram.to_string(),
            dram_peak_bytes_per_cycle: machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get()),
            ..MachineStats::default()
        };
        for (kind, units) in Kind::ALL.into_iter().zip(&self.units) {
            let (unit, level) = kind.names();
            let (counts, l1) = (sum(units.iter().map(|unit| &unit.cache)), sum(units.iter().map(|unit| &unit.l1)));
            stats.caches.insert(level.into(), cache_stats(&counts, Some(&l1)));
            stats.bytes.insert(level.into(), present(&sum(units.iter().map(|unit| &unit.requested))));
            stats.units.insert(unit.into(), sum_causes(units.iter().map(|unit| &unit.causes)));
            stats.operations.insert(unit.into(), units.iter().map(|unit| unit.operations).sum());
            stats.unit_counts.insert(unit.into(), units.len() as u64);
        }
        // A unit performs one division at a time, which occupies `interval` cycles.
        let divisions = self.divisions.iter().map(|causes| causes[Cause::Busy as usize]);
        let divisions = divisions.map(|busy| busy.div_ceil(machine.division.interval.get())).sum();
        stats.operations.insert("division".into(), divisions);
        stats.units.insert("division".into(), sum_causes(self.divisions.iter()));
        stats.unit_counts.insert("division".into(), self.divisions.len() as u64);
        stats.units.insert("dispatcher".into(), sum_causes(std::iter::once(&self.dispatcher)));
        for (kind, loads) in QueueKind::ALL.into_iter().zip(&self.queues).filter(|(_, loads)| !loads.is_empty()) {
            let entries = loads.iter().map(|load| load.entries).sum();
            let waited = loads.iter().map(|load| load.waited).sum();
            stats.queues.insert(kind.name().into(), QueueCounts { entries, waited });
        }
        // Every ray passes both FIFOs.
        let rays: u64 = self.queues[..2].iter().flatten().map(|load| load.entries).sum();
        if rays > 0 {
            let bytes = Bytes(rays * machine.dispatcher.ray_bytes.get());
            stats.bytes.insert("fifos".into(), [(TrafficClass::Ray, bytes)].into());
        }
        if machine.traffic.rays == RayBuffer::OnChip && !self.queues[0].is_empty() {
            let spec = &machine.traffic;
            let [read, written] = [0, 1].map(|fifo| self.queues[fifo].iter().map(|load| load.entries).sum::<u64>());
            let mut moved = PerClass::default();
            moved[TrafficClass::Ray as usize] = Bytes(read * spec.ray_bytes.get() + written * spec.hit_bytes.get());
            stats.bytes.insert("ray_buffer".into(), present(&moved));
        }
        let known = RayKind::ALL.into_iter().zip(self.latencies.kinds).filter(|(_, counts)| counts.rays > 0);
        stats.latency.extend(known.map(|(kind, counts)| (kind.name().to_owned(), counts)));
        if !self.has_causes {
            stats.units.values_mut().for_each(|causes| causes.retain(|&cause, _| cause == Cause::Busy));
        }
        stats.unit_counts.insert("dispatcher".into(), 1);
        let of_core = machine.l2.banks() as usize;
        let mut first = 0;
        for (name, cache) in machine.l2.caches() {
            let own = first..first + cache.banks.size();
            let banks = self.banks.chunks(of_core).flat_map(|banks| &banks[own.clone()]);
            stats.caches.insert(name.clone(), cache_stats(&sum(banks.clone().map(|bank| &bank.cache)), None));
            stats.bytes.insert(name, present(&sum(banks.map(|bank| &bank.served.moved))));
            first = own.end;
        }
        stats.bytes.insert("dram".into(), present(&sum(self.channels.iter().map(|channel| &channel.moved))));
        stats
    }
}

/// The sum over several parts, by class.
pub(crate) fn sum<'a, T: AddAssign + Copy + Default + 'a>(parts: impl Iterator<Item = &'a PerClass<T>>) -> PerClass<T> {
    let mut sum = PerClass::default();
    parts.for_each(|part| sum.iter_mut().zip(part).for_each(|(sum, &counted)| *sum += counted));
    sum
}

/// Accesses of the classes that were accessed; `l1` holds the further counts of an L1.
fn cache_stats(counts: &PerClass<CacheCounts>, l1: Option<&PerClass<L1Counts>>) -> BTreeMap<TrafficClass, CacheStats> {
    let l1 = |class: TrafficClass| l1.map(|counts| counts[class as usize]);
    present(counts).into_iter().map(|(class, counts)| (class, CacheStats { counts, l1: l1(class) })).collect()
}

/// The values that are not zero, by class; an absent class counts zero.
fn present<T: Default + PartialEq + Copy>(values: &PerClass<T>) -> BTreeMap<TrafficClass, T> {
    TrafficClass::ALL.into_iter().zip(*values).filter(|(_, value)| *value != T::default()).collect()
}

fn sum_causes<'a>(causes: impl Iterator<Item = &'a PerCause> + Clone) -> BTreeMap<Cause, u64> {
    let cycles = |cause: Cause| causes.clone().map(|causes| causes[cause as usize]).sum();
    Cause::ALL.into_iter().map(|cause| (cause, cycles(cause))).collect()
}
