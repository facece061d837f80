//! A rough estimate of a machine's cycles for a stream: the demand on each resource over its rate.

use serde::{Deserialize, Serialize};

use super::caches::{End, Misses};
use crate::energy;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::memory::dram::spec::Model;
use crate::memory::l2::L2Spec;
use crate::quantity::{Bytes, Cycle};
use crate::stats::{CacheStats, MachineStats, TrafficClass};
use crate::stream::Structure;

/// Exponent of the norm over resources: the busiest resource counts most, since resources overlap, but not wholly.
/// Assumed. 1 adds all resources; a large value leaves only the busiest. A surrogate learns the error.
const SHARPNESS: f64 = 3.0;

/// A rough estimate of a machine's cost for a stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Cycles.
    pub cycles: f64,
    /// Bytes moved to and from the DRAM.
    pub dram_bytes: f64,
    /// Energy in J; `None` if the energy of the DRAM is unknown.
    pub joules: Option<f64>,
    /// Minimum busy cycles of each resource, in the same order for all machines.
    pub resources: Vec<f64>,
}

/// Results of a pass for its own machine.
#[derive(Clone, Debug)]
pub(super) struct Demand<'a> {
    /// The machine of the pass.
    pub(super) reference: &'a MachineSpec,
    pub(super) structure: Structure,
    /// The statistics of the pass.
    pub(super) stats: MachineStats,
    /// The misses of the machine's tags in the timeless simulation.
    pub(super) misses: Misses,
}

fn total(of: &[f64]) -> f64 {
    of.iter().sum()
}

impl Demand<'_> {
    /// Estimates `machine`, whose tags had the misses `tags`.
    pub(super) fn estimate(&self, machine: &MachineSpec, tags: Misses) -> Estimate {
        let misses = self.misses(tags);
        let (mut resources, end) = (self.resources(machine, &misses), self.end(machine, &misses));
        let rays = resources.iter().map(|busy| busy.powf(SHARPNESS)).sum::<f64>().powf(SHARPNESS.recip());
        let cycles = rays + end;
        resources.push(end);
        let stats = self.stats_of(machine, &misses, cycles);
        let dram_bytes = stats.moved("dram").0 as f64;
        let joules = energy::of(machine, self.structure, &stats).map(|energy| energy.joules);
        Estimate { cycles, dram_bytes, joules, resources }
    }

    /// The misses of a machine: its tags' misses, scaled by the ratio of measured to tags' misses of the machine of the
    /// pass.
    fn misses(&self, tags: Misses) -> Misses {
        let mut found = tags;
        for kind in Kind::ALL {
            let known = self.counted(kind.names().1);
            let (found, reference) = (&mut found.l1[kind as usize], &self.misses.l1[kind as usize]);
            for (class, (accesses, misses)) in known.into_iter().enumerate() {
                found[class] = scale(found[class], reference[class], misses).min(accesses);
            }
        }
        for class in TrafficClass::ALL {
            let class = class as usize;
            let known: f64 = self.reference.l2.caches().iter().map(|(name, _)| self.counted(name)[class].1).sum();
            let asked: f64 = found.l1.iter().map(|kind| kind[class]).sum();
            let missed = scale(found.l2[class], self.misses.l2[class], known);
            found.l2[class] = if asked > 0.0 { missed.min(asked) } else { missed };
        }
        found
    }

    /// Bytes that the host moved in the pass.
    fn host_bytes(&self) -> u64 {
        let classes = self.stats.bytes.get("dram").into_iter().flatten();
        classes.filter(|(class, _)| class.is_of_host()).map(|(_, bytes)| bytes.0).sum()
    }

    /// Accesses and misses of a cache in the pass, by class.
    fn counted(&self, cache: &str) -> [(f64, f64); TrafficClass::ALL.len()] {
        let classes = self.stats.caches.get(cache);
        TrafficClass::ALL.map(|class| {
            let counts = classes.and_then(|classes| classes.get(&class)).map(|cache| cache.counts).unwrap_or_default();
            (counts.accesses as f64, counts.misses as f64)
        })
    }

    /// Busy cycles of each resource.
    fn resources(&self, machine: &MachineSpec, found: &Misses) -> Vec<f64> {
        let cores = machine.cores.get() as f64;
        let l2 = L2::of(&machine.l2);
        let dram = dram_latency(machine);
        let (asked, fetched): (f64, f64) = (found.l1.iter().map(|kind| total(kind)).sum(), total(&found.l2));
        // Wait of an L1 for its missed lines: a share of each class's lines comes from the DRAM.
        let from_dram = TrafficClass::ALL.map(|class| {
            let asked: f64 = found.l1.iter().map(|kind| kind[class as usize]).sum();
            if asked > 0.0 { found.l2[class as usize] / asked } else { 0.0 }
        });
        let wait = |misses: &[f64]| -> f64 {
            misses.iter().zip(from_dram).map(|(misses, share)| misses * (l2.latency + 2.0 + share * dram)).sum()
        };
        let (mut busy, mut held) = (Vec::new(), 0.0);
        for (kind, misses) in Kind::ALL.into_iter().zip(&found.l1) {
            let spec = kind.spec(machine);
            let (count, mut waits) = (spec.count as f64, wait(misses));
            let mut operations = self.stats.operations.get(kind.names().0).copied().unwrap_or(0) as f64;
            let mut accesses: f64 = self.counted(kind.names().1).iter().map(|(accesses, _)| accesses).sum();
            if kind == Kind::ShadowCache {
                // End-of-frame steps run after all others: their share is subtracted.
                let without = |all: f64, end: f64| (all - end).max(0.0);
                operations = without(operations, found.end.accesses);
                accesses = without(accesses, found.end.accesses);
                waits = scale(waits, total(misses), without(total(misses), found.end.l1));
            }
            let stay = operations * spec.latency as f64 + accesses * spec.cache.latency.get() as f64 + waits;
            if kind != Kind::ShadowCache {
                held += stay;
            }
            let begun = operations * spec.interval as f64 / (count * spec.width as f64);
            busy.push(begun.max(accesses / (count * spec.cache.accesses_per_cycle() as f64)));
            busy.push(stay / (count * spec.contexts.unwrap_or(u64::MAX) as f64));
            busy.push(waits / (count * spec.cache.mshrs.get() as f64));
        }
        let rays = self.stats.rays as f64;
        let dispatcher = &machine.dispatcher;
        let division = self.stats.operations.get("division").copied().unwrap_or(0) as f64;
        let traversal = Kind::Traversal.spec(machine).count as f64;
        busy.push(rays / (cores * dispatcher.per_cycle.get() as f64));
        busy.push((held + rays * dispatcher.latency.get() as f64) / machine.pool() as f64);
        busy.push(held / (traversal * machine.traversal.rays.get() as f64));
        busy.push(division * machine.division.interval.get() as f64 / (cores * machine.division.count.get() as f64));
        busy.push(asked / (cores * l2.banks));
        busy.push(fetched * dram / (cores * l2.registers));
        let line = machine.line_bytes.get() as f64;
        let bytes = (fetched + self.written(found)) * line + self.host_bytes() as f64;
        busy.push(machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get()).map_or(0.0, |peak| bytes / peak));
        busy
    }

    /// Cycles of end-of-frame updates, when nothing else runs.
    fn end(&self, machine: &MachineSpec, found: &Misses) -> f64 {
        let spec = Kind::ShadowCache.spec(machine);
        let (End { accesses, l1, l2 }, count) = (found.end, spec.count as f64);
        let at_hand = accesses * (spec.latency + spec.cache.latency.get()) as f64;
        let stay = at_hand + l1 * (L2::of(&machine.l2).latency + 2.0) + l2 * dram_latency(machine);
        let begun = accesses * spec.interval as f64 / (count * spec.width as f64);
        let asked = accesses / (count * spec.cache.accesses_per_cycle() as f64);
        begun.max(asked).max(stay / (count * spec.contexts.unwrap_or(u64::MAX) as f64))
    }

    /// Lines that the host reads and writes, which do not depend on cache misses.
    fn host_lines(&self) -> (u64, u64) {
        let all = self.host_bytes() / self.reference.line_bytes.get();
        let caches = self.reference.l2.caches();
        let missed: f64 = caches.iter().flat_map(|(name, _)| self.counted(name)).map(|(_, misses)| misses).sum();
        let reads = self.stats.dram.reads - missed as u64;
        (reads, all - reads)
    }

    /// Lines that caches write to the DRAM: per missed line of each class, as in the pass.
    fn written(&self, misses: &Misses) -> f64 {
        let known = (self.stats.dram.writes - self.host_lines().1) as f64;
        let (mut reference, mut found) = (0.0, 0.0);
        for (name, _) in self.reference.l2.caches() {
            for (&class, cache) in self.stats.caches.get(&name).into_iter().flatten() {
                let (written, missed) = (cache.counts.write_backs as f64, cache.counts.misses as f64);
                reference += written;
                found += scale(written, missed, misses.l2[class as usize]);
            }
        }
        if reference > 0.0 { known * found / reference } else { known }
    }

    /// The statistics of the pass with the misses and the cycles of `machine`.
    fn stats_of(&self, machine: &MachineSpec, misses: &Misses, cycles: f64) -> MachineStats {
        let mut stats = self.stats.clone();
        (stats.cycles, stats.clock_mhz) = (Cycle(cycles as u64), machine.clock_mhz.get() as f64);
        for (kind, misses) in Kind::ALL.into_iter().zip(&misses.l1) {
            for (&class, cache) in stats.caches.get_mut(kind.names().1).into_iter().flatten() {
                set(cache, None, misses[class as usize]);
            }
        }
        for (name, _) in machine.l2.caches() {
            for (&class, cache) in stats.caches.get_mut(&name).into_iter().flatten() {
                let asked: f64 = misses.l1.iter().map(|kind| kind[class as usize]).sum();
                set(cache, Some(asked), misses.l2[class as usize]);
            }
        }
        let (host_reads, host_writes) = self.host_lines();
        let fetched = total(&misses.l2);
        let written = self.written(misses) as u64;
        let (known, found) = (stats.dram.reads as f64, fetched + host_reads as f64);
        let dram = &mut stats.dram;
        for count in [&mut dram.row_hits, &mut dram.row_misses, &mut dram.row_conflicts, &mut dram.activates] {
            *count = scale(*count as f64, known, found) as u64;
        }
        (dram.reads, dram.writes) = (fetched as u64 + host_reads, written + host_writes);
        let bytes = (fetched as u64 + written) * machine.line_bytes.get();
        let moved = (stats.moved("dram").0 - self.host_bytes()) as f64;
        if let Some(classes) = stats.bytes.get_mut("dram") {
            let cached = classes.iter_mut().filter(|(class, _)| !class.is_of_host());
            cached.for_each(|(_, of)| *of = Bytes(scale(of.0 as f64, moved, bytes as f64) as u64));
        }
        stats
    }
}

/// `found` times the ratio of `known` to `reference`; unchanged if `reference` is 0.
fn scale(found: f64, reference: f64, known: f64) -> f64 {
    if reference > 0.0 { found * known / reference } else { found }
}

/// Sets the misses of a class in a cache, and its accesses if given; write-backs scale with the misses.
fn set(cache: &mut CacheStats, accesses: Option<f64>, misses: f64) {
    let counts = &mut cache.counts;
    counts.write_backs = scale(counts.write_backs as f64, counts.misses as f64, misses) as u64;
    counts.accesses = accesses.map_or(counts.accesses, |accesses| accesses as u64 + counts.write_backs);
    counts.misses = misses as u64;
}

/// All caches of a core's L2 together.
struct L2 {
    latency: f64,
    banks: f64,
    registers: f64,
}

impl L2 {
    fn of(spec: &L2Spec) -> Self {
        let mut all = Self { latency: 0.0, banks: 0.0, registers: 0.0 };
        for (_, cache) in spec.caches() {
            all.latency = all.latency.max(cache.latency.get() as f64);
            all.banks += cache.banks.get() as f64;
            all.registers += (cache.banks.get() * cache.mshrs.get()) as f64;
        }
        all
    }
}

/// Cycles from a request to an idle DRAM to its data, including an activate.
fn dram_latency(machine: &MachineSpec) -> f64 {
    let (dram, timing) = (&machine.dram, &machine.dram.part.timing);
    match dram.model {
        Model::Flat { latency, .. } => latency.get() as f64,
        Model::Banks => {
            let clocks = timing.rcd.get() + timing.cl.get() + dram.part.burst_clocks.get();
            dram.clocks(machine.clock_mhz.get()).cycle_after(clocks) as f64
        }
    }
}
