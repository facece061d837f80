//! The identities that every run must keep.

use super::error::RunError;
use super::tally::{PerClass, QueueKind, Tally, UnitTally, sum};
use crate::engine::source::{FrameCounts, StoreWork};
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::{FrameEnd, ShadowCacheSpec};
use crate::machine::traffic::RayBuffer;
use crate::machine::word_traffic::{Decide, LatchedCopy, SilentUpdates};
use crate::memory::cache::BypassCounts;
use crate::memory::dram::spec::Model;
use crate::stats::{Bounds, MachineStats, TrafficClass};

/// Checks that the machine replayed what the tracer counted for a frame, and deviated only where its spec allows it.
pub(crate) fn frame(counts: &FrameCounts, spec: &ShadowCacheSpec) -> Result<(), RunError> {
    let FrameCounts { frame, tracer, machine, stores } = counts;
    let StoreWork {
        merged_reads,
        merged_writes,
        raised_reads,
        added_writes,
        deferred_writes,
        covered_writes,
        dropped_writes,
        added_reads,
        gathered_writes,
        answered_rays,
    } = *stores;
    let lazy = spec.frame_end == FrameEnd::Epoch;
    let sweeps = spec.frame_end == FrameEnd::Sweep;
    let buffers = spec.latched == LatchedCopy::Buffers;
    let only = |allowed: bool, what, count| (what, count, if allowed { count } else { 0 });
    let performed_otherwise =
        machine.policy_writes + merged_writes + deferred_writes + covered_writes + dropped_writes + gathered_writes;
    let droppable = match spec.silent {
        SilentUpdates::Sent => 0,
        SilentUpdates::Latched => tracer.silent_updates,
        SilentUpdates::Live => tracer.silent_updates + tracer.repeated_updates,
    };
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
        ("reads of the policy", machine.policy_reads + merged_reads + raised_reads, tracer.policy_reads + added_reads),
        ("writes of the policy", performed_otherwise, tracer.policy_writes + added_writes + raised_reads),
        ("updates dropped at rays", dropped_writes, droppable),
        only(spec.gather.get() > 0, "updates gathered without a table", gathered_writes),
        only(spec.decide == Decide::Hit, "rays that the host answers with `decide: Unit`", answered_rays),
        only(spec.register.get() > 0, "merged steps without a register", merged_reads + merged_writes),
        only(lazy, "first touches without `Epoch`", raised_reads + deferred_writes),
        only(sweeps, "swept steps without `Sweep`", covered_writes),
        only(buffers, "added reads without `Buffers`", added_reads),
        only(lazy || sweeps || buffers, "added steps with `List`", added_writes),
    ];
    match pairs.into_iter().find(|(_, machine, tracer)| machine != tracer) {
        Some((what, machine, tracer)) => Err(RunError::Counts { frame: *frame, what, machine, tracer }),
        None => Ok(()),
    }
}

fn equal(what: impl FnOnce() -> String, left: u64, right: u64) -> Result<(), String> {
    if left == right { Ok(()) } else { Err(format!("{}: {left} against {right}", what())) }
}

/// Checks that the run lies within bounds that hold for every machine and stream.
pub(crate) fn bounds(stats: &MachineStats, bounds: &Bounds) -> Result<(), String> {
    let cycles = [bounds.cycles.least.0, bounds.cycles.most.0];
    let [l2, dram] = [bounds.l2_bytes, bounds.dram_bytes].map(|bytes| [bytes.least.0, bytes.most.0]);
    let found = [
        ("cycles", stats.cycles.0, cycles),
        ("L2 bytes", stats.moved_l2().0, l2),
        ("DRAM bytes", stats.moved("dram").0, dram),
    ];
    match found.into_iter().find(|(_, found, [least, most])| found < least || found > most) {
        Some((what, found, [least, most])) => Err(format!("{found} {what} are not within {least} to {most}")),
        None => Ok(()),
    }
}

/// Checks the run's identities; the error names the numbers.
pub(crate) fn run(tally: &Tally, machine: &MachineSpec) -> Result<(), String> {
    for (name, classes) in &tally.stats(machine).caches {
        for (class, counts) in classes {
            let what =
                || format!("{name}, {}: hits + MSHR hits + misses + passed writes against accesses", class.name());
            let found = counts.hits + counts.mshr_hits + counts.misses + counts.passed_writes;
            equal(what, found, counts.accesses)?;
        }
    }
    let causes =
        tally.units.iter().flatten().map(|unit| &unit.causes).chain(&tally.divisions).chain([&tally.dispatcher]);
    for causes in causes.filter(|_| tally.has_causes) {
        equal(|| "cycles of all causes of a unit".into(), causes.iter().sum(), tally.cycles)?;
    }
    for (kind, loads) in QueueKind::ALL.into_iter().zip(&tally.queues) {
        for (index, load) in loads.iter().enumerate() {
            // Little's law, summed over the run; all queues are empty at its end.
            let what = || format!("places taken a cycle in the queue of {} {index} against cycles waited", kind.name());
            equal(what, load.occupied, load.waited)?;
        }
    }
    let through = |kind: QueueKind| tally.queues[kind as usize].iter().map(|load| load.entries).sum();
    equal(|| "rays into and out of the FIFOs".into(), through(QueueKind::Dispatcher), through(QueueKind::Host))?;
    host(tally, machine)?;
    equal(|| "rays that took less than their least latency".into(), tally.latencies.too_fast, 0)?;
    traffic(tally, machine)?;
    dram(tally, machine)
}

/// Checks lines of rays and hits against the rays through the FIFOs, for engines that count cycles by cause.
fn host(tally: &Tally, machine: &MachineSpec) -> Result<(), String> {
    let (spec, line) = (&machine.traffic, machine.line_bytes.get());
    if spec.rays != RayBuffer::Dram || !tally.has_causes {
        return Ok(());
    }
    let through = |kind: QueueKind| tally.queues[kind as usize].iter().map(|load| load.entries).sum::<u64>();
    let lines = |kind: QueueKind, bytes: u64| (through(kind) * bytes).div_ceil(line);
    let (rays, hits) =
        (lines(QueueKind::Dispatcher, spec.ray_bytes.get()), lines(QueueKind::Host, spec.hit_bytes.get()));
    equal(|| "lines of rays".into(), tally.port.reads[TrafficClass::Ray as usize], rays)?;
    equal(|| "lines of hits".into(), tally.port.writes[TrafficClass::Ray as usize], hits)
}

/// Checks that accesses and bytes are conserved between memory levels, class by class.
fn traffic(tally: &Tally, machine: &MachineSpec) -> Result<(), String> {
    let line = machine.line_bytes.get();
    let units = || tally.units.iter().flatten();
    let l1 = sum(units().map(|unit| &unit.cache));
    let l2 = sum(tally.banks.iter().map(|bank| &bank.cache));
    let moved = sum(tally.banks.iter().map(|bank| &bank.served.moved));
    let dram = sum(tally.channels.iter().map(|channel| &channel.moved));
    for class in TrafficClass::ALL {
        let (index, name) = (class as usize, class.name());
        let past = |of: fn(&UnitTally) -> &PerClass<BypassCounts>| {
            let all = units().map(|unit| of(unit)[index]);
            all.fold((0, 0), |(count, bytes), past| (count + past.count, bytes + past.bytes.0))
        };
        let (through, through_bytes) = past(|unit| &unit.written_through);
        let (bypassed, bypassed_bytes) = past(|unit| &unit.bypassed);
        let reads: u64 = tally.banks.iter().map(|bank| bank.served.reads[index]).sum();
        let (l1, l2) = (&l1[index], &l2[index]);
        equal(|| format!("{name}: misses of the L1s against reads of the L2"), l1.misses + bypassed, reads)?;
        equal(
            || format!("{name}: writes of the L1s against writes of the L2"),
            l1.write_backs + through,
            l2.accesses - reads,
        )?;
        let down = (l1.misses + l1.write_backs) * line + through_bytes + bypassed_bytes;
        equal(|| format!("{name}: bytes between L1s and L2"), down, moved[index].0)?;
        let lines = l2.misses + l2.write_backs + l2.passed_writes + tally.port.reads[index] + tally.port.writes[index];
        equal(|| format!("{name}: bytes of L2 and host against DRAM"), lines * line, dram[index].0)?;
    }
    Ok(())
}

fn dram(tally: &Tally, machine: &MachineSpec) -> Result<(), String> {
    let counts = tally.commands();
    let columns = counts.reads + counts.writes;
    let flat = machine.dram.model != Model::Banks;
    equal(
        || "row hits + misses + conflicts against column commands".into(),
        counts.row_hits + counts.row_misses + counts.row_conflicts,
        if flat { 0 } else { columns },
    )?;
    let bytes: u64 = tally.channels.iter().flat_map(|channel| channel.moved).map(|bytes| bytes.0).sum();
    equal(|| "column commands times the line against DRAM bytes".into(), columns * machine.line_bytes.get(), bytes)?;
    let l2: u64 = tally.banks.iter().flat_map(|bank| bank.cache).map(|counts| counts.misses).sum();
    let host: u64 = tally.port.reads.iter().sum();
    equal(|| "DRAM reads against misses of the L2 and reads of the host".into(), counts.reads, l2 + host)?;
    let (spec, mhz) = (&machine.dram, machine.clock_mhz.get());
    if let Some((peak, cycles)) = spec.channel_peak(mhz)
        && u128::from(bytes) * u128::from(cycles) > u128::from(spec.channels.get() * peak) * u128::from(tally.cycles)
    {
        return Err(format!(
            "{bytes} DRAM bytes in {} cycles exceed the peak of {} bytes in {cycles} cycles of each of {} channel(s)",
            tally.cycles, peak, spec.channels
        ));
    }
    // The first clock is 0, in which no refresh is due.
    let last = spec.clocks(mhz).first(tally.cycles) - 1;
    let due = if flat { 0 } else { last / spec.part.timing.refi.get() };
    for (index, channel) in tally.channels.iter().enumerate() {
        let given = channel.counts.refreshes + u64::from(channel.refresh_due);
        equal(|| format!("refreshes of channel {index}, given and due"), given, due)?;
    }
    Ok(())
}
