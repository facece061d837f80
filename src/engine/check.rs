//! What a run measured, gathered from all parts, and the identities that it must keep.

use std::collections::BTreeMap;

use super::RunError;
use super::event::Event;
use crate::machine::MachineSpec;
use crate::machine::causes::Causes;
use crate::machine::dispatcher::FrameCounts;
use crate::machine::pipeline::Pipeline;
use crate::memory::cache::Cache;
use crate::quantity::{Bytes, Cycle};
use crate::stats::{CacheCounts, Cause, DramCounts, MachineStats, TrafficClass};

/// Something a class of traffic, in the order of [`TrafficClass::ALL`].
type PerClass<T> = [T; TrafficClass::ALL.len()];

/// Checks that the machine replayed of a frame what the tracer counted.
pub(super) fn frame<E>(counts: &FrameCounts) -> Result<(), RunError<E>> {
    let FrameCounts { frame, tracer, machine } = counts;
    let pairs = [
        ("primary rays", machine.primary_rays, tracer.primary_rays),
        ("secondary rays", machine.secondary_rays, tracer.secondary_rays),
        ("shadow rays", machine.shadow_rays, tracer.shadow_rays),
        ("skipped shadow rays", machine.shadow_rays_skipped, tracer.shadow_rays_skipped),
        ("shadow rays among dynamic objects", machine.shadow_rays_dynamic_only, tracer.shadow_rays_dynamic_only),
        ("node visits", machine.node_visits, tracer.node_visits),
        ("triangle tests", machine.triangle_tests, tracer.triangle_tests),
        ("node visits of shadow rays", machine.shadow_node_visits, tracer.shadow_node_visits),
        ("triangle tests of shadow rays", machine.shadow_triangle_tests, tracer.shadow_triangle_tests),
        ("list reads", machine.list_reads, tracer.list_reads),
        ("triangle tests of the policy", machine.policy_triangle_tests, tracer.policy_triangle_tests),
        ("node visits of the policy", machine.policy_node_visits, tracer.policy_node_visits),
        ("reads of the policy", machine.policy_reads, tracer.policy_reads),
        ("writes of the policy", machine.policy_writes, tracer.policy_writes),
    ];
    match pairs.into_iter().find(|(_, machine, tracer)| machine != tracer) {
        Some((what, machine, tracer)) => Err(RunError::Counts { frame: *frame, what, machine, tracer }),
        None => Ok(()),
    }
}

fn add(sum: &mut PerClass<CacheCounts>, cache: &Cache) {
    for (sum, counts) in sum.iter_mut().zip(cache.counts()) {
        sum.accesses += counts.accesses;
        sum.hits += counts.hits;
        sum.half_misses += counts.half_misses;
        sum.misses += counts.misses;
        sum.write_backs += counts.write_backs;
    }
}

fn sum_caches<'a>(caches: impl Iterator<Item = &'a Cache>) -> PerClass<CacheCounts> {
    let mut sum = PerClass::default();
    caches.for_each(|cache| add(&mut sum, cache));
    sum
}

fn sum_bytes<'a>(moved: impl Iterator<Item = &'a PerClass<Bytes>>) -> PerClass<Bytes> {
    let mut sum = PerClass::default();
    moved.for_each(|moved| sum.iter_mut().zip(moved).for_each(|(sum, &moved)| *sum += moved));
    sum
}

/// What is not zero, by class: absent is absent.
fn present<T: Default + PartialEq + Copy>(values: &PerClass<T>) -> BTreeMap<TrafficClass, T> {
    TrafficClass::ALL.into_iter().zip(*values).filter(|(_, value)| *value != T::default()).collect()
}

fn sum_causes<'a>(causes: impl Iterator<Item = &'a Causes>, cycles: u64) -> BTreeMap<Cause, u64> {
    let mut sum: BTreeMap<Cause, u64> = Cause::ALL.into_iter().map(|cause| (cause, 0)).collect();
    for (cause, count) in causes.flat_map(|causes| causes.until(cycles)) {
        *sum.entry(cause).or_default() += count;
    }
    sum
}

/// Gathers what a run of `cycles` measured.
pub(super) fn collect(engine: &Event, machine: &MachineSpec, cycles: u64) -> MachineStats {
    let mut stats = MachineStats {
        cycles: Cycle(cycles),
        clock_mhz: machine.clock_mhz.get() as f64,
        rays: engine.dispatcher.rays(),
        dram_peak_bytes_per_cycle: machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get()),
        ..MachineStats::default()
    };
    for (unit, level, pipelines) in engine.pipelines() {
        let name = level.to_owned();
        stats.caches.insert(name.clone(), present(&sum_caches(pipelines.iter().map(|pipeline| pipeline.cache()))));
        stats.bytes.insert(name, present(&sum_bytes(pipelines.iter().map(|pipeline| pipeline.requested()))));
        stats.units.insert(unit.to_owned(), sum_causes(pipelines.iter().map(|pipeline| pipeline.causes()), cycles));
        stats.unit_counts.insert(unit.to_owned(), pipelines.len() as u64);
    }
    stats.units.insert("dispatcher".into(), sum_causes(std::iter::once(&engine.dispatcher.causes), cycles));
    stats.unit_counts.insert("dispatcher".into(), 1);
    let banks = &engine.links.l2.banks;
    stats.caches.insert("l2".into(), present(&sum_caches(banks.iter().map(|bank| bank.cache()))));
    stats.bytes.insert("l2".into(), present(&sum_bytes(banks.iter().map(|bank| bank.moved()))));
    let dram = &engine.links.dram;
    stats.bytes.insert("dram".into(), present(&dram.moved()));
    for counts in (0..dram.channels()).map(|index| dram.counts(index)) {
        let DramCounts { reads, writes, row_hits, row_misses, row_conflicts, refreshes } = *counts;
        stats.dram.reads += reads;
        stats.dram.writes += writes;
        stats.dram.row_hits += row_hits;
        stats.dram.row_misses += row_misses;
        stats.dram.row_conflicts += row_conflicts;
        stats.dram.refreshes += refreshes;
    }
    stats
}

fn equal(what: impl FnOnce() -> String, left: u64, right: u64) -> Result<(), String> {
    if left == right { Ok(()) } else { Err(format!("{}: {left} against {right}", what())) }
}

/// Checks the run's identities; the error names the numbers.
pub(super) fn run(engine: &Event, machine: &MachineSpec, stats: &MachineStats) -> Result<(), String> {
    for (name, classes) in &stats.caches {
        for (class, counts) in classes {
            let what = || format!("{name}, {}: hits + half misses + misses against accesses", class.name());
            equal(what, counts.hits + counts.half_misses + counts.misses, counts.accesses)?;
        }
    }
    for (name, causes) in &stats.units {
        let count = stats.unit_counts.get(name).copied().unwrap_or(0);
        equal(|| format!("{name}: cycles of all causes"), causes.values().sum(), stats.cycles.0 * count)?;
    }
    traffic(engine, machine)?;
    dram(engine, machine, stats)
}

/// Conservation between the levels, a class at a time.
fn traffic(engine: &Event, machine: &MachineSpec) -> Result<(), String> {
    let line = machine.line_bytes.get();
    let pipelines: Vec<&Pipeline> = engine.pipelines().into_iter().flat_map(|(.., pipelines)| pipelines).collect();
    let banks = &engine.links.l2.banks;
    let l1 = sum_caches(pipelines.iter().map(|pipeline| pipeline.cache()));
    let l2 = sum_caches(banks.iter().map(|bank| bank.cache()));
    let moved = sum_bytes(banks.iter().map(|bank| bank.moved()));
    let dram = engine.links.dram.moved();
    for class in TrafficClass::ALL {
        let (index, name) = (class as usize, class.name());
        let through: u64 = pipelines.iter().map(|pipeline| pipeline.written_through()[index].writes).sum();
        let through_bytes: u64 = pipelines.iter().map(|pipeline| pipeline.written_through()[index].bytes.0).sum();
        let reads: u64 = banks.iter().map(|bank| bank.reads()[index]).sum();
        let (l1, l2) = (&l1[index], &l2[index]);
        equal(|| format!("{name}: misses of the L1s against reads of the L2"), l1.misses, reads)?;
        let writes = l1.write_backs + through;
        equal(|| format!("{name}: writes of the L1s against writes of the L2"), writes, l2.accesses - reads)?;
        let down = (l1.misses + l1.write_backs) * line + through_bytes;
        equal(|| format!("{name}: bytes between L1s and L2"), down, moved[index].0)?;
        equal(|| format!("{name}: bytes between L2 and DRAM"), (l2.misses + l2.write_backs) * line, dram[index].0)?;
    }
    Ok(())
}

fn dram(engine: &Event, machine: &MachineSpec, stats: &MachineStats) -> Result<(), String> {
    let counts = &stats.dram;
    let columns = counts.reads + counts.writes;
    equal(
        || "row hits + misses + conflicts against column commands".into(),
        counts.row_hits + counts.row_misses + counts.row_conflicts,
        columns,
    )?;
    let bytes: u64 =
        stats.bytes.get("dram").into_iter().flat_map(|classes| classes.values()).map(|bytes| bytes.0).sum();
    equal(|| "column commands times the line against DRAM bytes".into(), columns * machine.line_bytes.get(), bytes)?;
    let l2 = stats.caches.get("l2").into_iter().flat_map(|classes| classes.values());
    equal(|| "DRAM reads against misses of the L2".into(), counts.reads, l2.map(|counts| counts.misses).sum())?;
    let spec = &machine.dram;
    let time = u128::from(bytes) * u128::from(spec.burst_clocks.get() * machine.clock_mhz.get());
    let peak = u128::from(spec.channels.get() * spec.burst_bytes.get() * spec.clock_mhz.get());
    if time > peak * u128::from(stats.cycles.0) {
        return Err(format!(
            "{bytes} DRAM bytes in {} cycles exceed the peak of {} bytes a cycle",
            stats.cycles, stats.dram_peak_bytes_per_cycle
        ));
    }
    let last = stats.cycles.0 - 1;
    let links = &engine.links;
    for index in 0..links.dram.channels() {
        let given = links.dram.counts(index).refreshes + u64::from(links.dram.refresh_is_due(index, last));
        equal(|| format!("refreshes of channel {index}, given and due"), given, last / links.dram.timing().refi)?;
    }
    Ok(())
}
