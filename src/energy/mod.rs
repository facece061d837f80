//! The energy that a machine uses: counts times constants. `docs/model/energy.md` describes the rules.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::memory::dram::power::DramWork;
use crate::spread::Spread;
use crate::stats::{CacheCounts, CacheStats, Energy, MachineStats, TrafficClass};
use crate::stream::Structure;

/// Joules in a picojoule.
const PICO: f64 = 1e-12;
/// Picojoules of one milliwatt in one second.
const MILLIWATT: f64 = 1e9;

/// The energy of the work that `stats` counts, for streams of a structure; `None` if the DRAM's energy is unknown.
pub(crate) fn of(machine: &MachineSpec, structure: Structure, stats: &MachineStats) -> Option<Energy> {
    let seconds = stats.cycles.0 as f64 / (stats.clock_mhz * 1e6);
    let line_bytes = machine.line_bytes.get();
    let dram = machine.dram.energy(&DramWork { counts: stats.dram, line_bytes, seconds })?;
    let mut sum = Sum::default();
    units(machine, structure, stats, &mut sum);
    caches(machine, stats, &mut sum);
    let leakage = leakage(machine) * (MILLIWATT * seconds);
    sum.add("leakage", leakage);
    commands(&dram, stats, &mut sum);
    Some(sum.energy())
}

/// Energies by part, and typical energies by class, in pJ.
#[derive(Default)]
struct Sum {
    by: BTreeMap<String, Spread>,
    classes: BTreeMap<TrafficClass, f64>,
}

impl Sum {
    fn add(&mut self, part: &str, energy: Spread) {
        *self.by.entry(part.to_owned()).or_default() += energy;
    }

    fn add_class(&mut self, class: TrafficClass, energy: f64) {
        *self.classes.entry(class).or_default() += energy;
    }

    fn energy(self) -> Energy {
        let by: BTreeMap<_, _> = self.by.iter().map(|(part, energy)| (part.clone(), energy.typical * PICO)).collect();
        Energy {
            joules: by.values().sum(),
            low: self.by.values().map(|energy| energy.low * PICO).sum(),
            high: self.by.values().map(|energy| energy.high * PICO).sum(),
            by,
            classes: self.classes.into_iter().map(|(class, energy)| (class, energy * PICO)).collect(),
        }
    }
}

/// Energy of the units' operations, and of rays that pass the dispatcher and the FIFOs.
fn units(machine: &MachineSpec, structure: Structure, stats: &MachineStats, sum: &mut Sum) {
    let spec = &machine.energy;
    for (name, operation) in [
        ("traversal", spec.node(structure)),
        ("list", spec.list),
        ("intersection", spec.intersection),
        ("division", spec.division),
        ("shadow_cache", spec.shadow_cache),
    ] {
        let begun = stats.operations.get(name).copied().unwrap_or(0);
        sum.add(name, operation * begun as f64);
    }
    sum.add("dispatcher", spec.dispatcher * stats.rays as f64);
    sum.add("fifos", spec.fifo_byte * stats.moved("fifos").0 as f64);
    if let Some(bytes) = stats.bytes.get("ray_buffer") {
        // Priced as a FIFO.
        let moved: u64 = bytes.values().map(|bytes| bytes.0).sum();
        sum.add("ray_buffer", spec.fifo_byte * moved as f64);
    }
}

/// Energy of all cache accesses: each reads or writes a line, and so does each fill and each write-back.
fn caches(machine: &MachineSpec, stats: &MachineStats, sum: &mut Sum) {
    let l1s = Kind::ALL.map(|kind| (kind, kind.spec(machine).cache));
    let l1s = l1s.map(|(kind, cache)| (kind.names().1.to_owned(), cache.bytes.get(), cache.ways.get()));
    // An access activates one bank only.
    let l2 = machine.l2.caches().into_iter();
    let l2 = l2.map(|(name, cache)| (name, cache.bytes.get() / cache.banks.get(), cache.ways.get()));
    for (name, bytes, ways) in l1s.into_iter().chain(l2) {
        let access = machine.energy.cache.access(bytes, ways, machine.line_bytes.get());
        for (&class, CacheStats { counts, .. }) in stats.caches.get(&name).into_iter().flatten() {
            let CacheCounts { accesses, misses, write_backs, .. } = *counts;
            let energy = access * (accesses + misses + write_backs) as f64;
            sum.add(&name, energy);
            sum.add_class(class, energy.typical);
        }
    }
}

/// Energy of the DRAM's commands, split between classes by the bytes that they moved.
fn commands(dram: &[(&'static str, Spread)], stats: &MachineStats, sum: &mut Sum) {
    dram.iter().for_each(|&(part, energy)| sum.add(part, energy));
    let of_data = dram.iter().filter(|(part, _)| !["dram_refresh", "dram_background"].contains(part));
    let of_data: f64 = of_data.map(|(_, energy)| energy.typical).sum();
    let moved = stats.moved("dram").0 as f64;
    for (&class, bytes) in stats.bytes.get("dram").into_iter().flatten() {
        sum.add_class(class, of_data * bytes.0 as f64 / moved);
    }
}

/// Leakage of all units and caches, in mW.
fn leakage(machine: &MachineSpec) -> Spread {
    let spec = &machine.energy;
    let kinds = Kind::ALL.map(|kind| kind.spec(machine));
    let units: u64 = kinds.iter().map(|kind| kind.count).sum();
    let divisions = machine.cores.get() * machine.division.count.get();
    let l1s = kinds.iter().map(|kind| spec.cache.leakage(kind.cache.bytes.get()) * kind.count as f64);
    let l2 = machine.l2.caches().into_iter().map(|(_, cache)| spec.cache.leakage(cache.bytes.get()));
    let l2 = l2.sum::<Spread>() * machine.cores.get() as f64;
    spec.unit_leakage * (units + divisions + 1) as f64 + l1s.sum() + l2
}
