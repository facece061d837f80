//! Closed-form bounds from the sums of a stream.

use super::phases::Bound;
use super::sums::Sums;
use crate::energy;
use crate::engine::error::RunError;
use crate::engine::items::ItemStream;
use crate::engine::tally::PerClass;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::memory::dram::part::Timing;
use crate::memory::dram::spec::Model;
use crate::quantity::{Bytes, Cycle};
use crate::stats::{Accuracy, Bounds, Cause, Limit, MachineStats, Range, TrafficClass};
use crate::stream::Header;

impl Bound {
    /// The sum of all frames that are not in `left_out`.
    fn sum(&self, left_out: &[u32]) -> Sums {
        let mut sum = Sums::default();
        self.frames.iter().filter(|(frame, _)| !left_out.contains(frame)).for_each(|(_, frame)| sum += frame);
        sum
    }

    /// The bounds of all frames except those of `warmup`. A line without an earlier touch must be fetched. A line
    /// written in a frame of `warmup` may be written back later.
    pub(in crate::engine) fn bounds(&self, warmup: &[u32]) -> Bounds {
        let (measured, all) = (self.sum(warmup), self.sum(&[]));
        let line = self.machine.line_bytes.get();
        let bytes = |bytes: &PerClass<Bytes>| bytes.iter().copied().sum::<Bytes>();
        // Upper bound: each access fetches its line; each write can cause a write-back, whose line must also be
        // fetched.
        let left_out = if self.steps.stores_count { 0 } else { 2 * all.left_out };
        let (accesses, writes) = (measured.accesses.iter().sum::<u64>() + left_out, all.writes + left_out);
        let l2 = Bytes((accesses + writes) * line);
        let dram = Bytes((accesses + 3 * writes + measured.host_lines) * line);
        let most = self.serial_cycles(&measured, left_out, dram.0 / line);
        Bounds {
            cycles: Range { least: Cycle(measured.cycles), most: Cycle(most) },
            l2_bytes: Range { least: bytes(&measured.l2), most: l2 },
            dram_bytes: Range { least: bytes(&measured.dram), most: dram },
        }
    }

    /// Cycles if everything happens one after another, with `requests` requests to the DRAM. Each request waits for all
    /// constraints that can precede it.
    fn serial_cycles(&self, sums: &Sums, left_out: u64, requests: u64) -> u64 {
        let operations: u64 = self
            .steps
            .kinds
            .iter()
            .zip(sums.operations.iter().zip(&sums.accesses))
            .map(|(unit, (operations, accesses))| operations * (unit.latency + 8) + accesses * unit.cache.latency.get())
            .sum();
        let unit = &self.steps.kinds[Kind::ShadowCache as usize];
        let operations = operations + left_out * (unit.latency + unit.cache.latency.get() + 16);
        let l2 = self.machine.l2.caches().iter().map(|(_, cache)| cache.latency.get()).max().unwrap_or(0);
        let served = |request| sums.serial + operations + requests * (request + 2 * l2 + 16) + 1000;
        let part = &self.machine.dram.part;
        let line = self.machine.line_bytes.get();
        if let Model::Flat { latency, bytes_per_cycle } = self.machine.dram.model {
            return served(latency.get() + 1 + bytes_per_cycle.map_or(0, |bytes| line.div_ceil(bytes.get())));
        }
        let Timing { cl, cwl, rcd, rp, ras, rc, ccd_l, rrd_l, faw, rtp, wr, wtr_l, turn, refi, rfc, .. } = part.timing;
        let line = line / part.burst_bytes.get() * (part.burst_clocks.get() + ccd_l.get());
        let waits = [cl, cwl, rcd, rp, ras, rrd_l, faw, rtp, wr, wtr_l].map(|wait| wait.get());
        let clocks = self.machine.dram.clocks(self.machine.clock_mhz.get());
        let request = clocks.cycle_after(waits.iter().sum::<u64>() + turn.get() + rc.get() + 2 * line);
        // More than half of the time between refreshes is usable: the check of the spec ensures it.
        2 * served(request) + 2 * clocks.cycle_after(refi.get() + rfc.get())
    }

    /// The lower bound in the form of measured statistics.
    fn stats(&self, sums: &Sums) -> MachineStats {
        let machine = &self.machine;
        let present = |bytes: &[Bytes]| {
            let all = TrafficClass::ALL.into_iter().zip(bytes.iter().copied());
            all.filter(|(_, bytes)| bytes.0 > 0).collect()
        };
        let mut stats = MachineStats {
            cycles: Cycle(sums.cycles),
            clock_mhz: machine.clock_mhz.get() as f64,
            rays: sums.traced,
            dram_organization: machine.dram.to_string(),
            dram_peak_bytes_per_cycle: machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get()),
            ..MachineStats::default()
        };
        stats.dram.reads = sums.first_touches + sums.host_reads;
        stats.dram.writes = sums.host_lines - sums.host_reads;
        for (home, (name, _)) in machine.l2.caches().into_iter().enumerate() {
            let mut here = sums.l2;
            let elsewhere = TrafficClass::ALL.into_iter().filter(|&class| machine.l2.home(class) != home);
            elsewhere.for_each(|class| here[class as usize] = Bytes(0));
            stats.bytes.insert(name, present(&here));
        }
        stats.bytes.insert("dram".into(), present(&sums.dram));
        for (kind, unit) in Kind::ALL.into_iter().zip(&self.steps.kinds) {
            let (name, level) = kind.names();
            stats.bytes.insert(level.into(), present(&sums.requested[kind as usize]));
            let busy = (sums.operations[kind as usize] * unit.interval).div_ceil(unit.width);
            stats.units.insert(name.into(), [(Cause::Busy, busy)].into());
            stats.operations.insert(name.into(), sums.operations[kind as usize]);
            stats.unit_counts.insert(name.into(), unit.count);
        }
        stats
    }
}

/// The `Bound` level: the bounds of a machine on this stream, and its lower bounds with all shadow rays' answers known.
pub(in crate::engine) fn run(
    machine: &MachineSpec,
    header: &Header,
    items: &mut ItemStream<'_>,
) -> Result<MachineStats, RunError> {
    let (mut bound, mut oracle) = (Bound::new(machine, header, false), Bound::new(machine, header, true));
    for item in items {
        let item = item?;
        bound.add(&item);
        oracle.add(&item);
    }
    let limit = oracle.bounds(&header.warmup);
    let stats = |sums: &Sums| {
        let stats = bound.stats(sums);
        MachineStats { energy: energy::of(machine, header.structure, &stats), ..stats }
    };
    let frame =
        |(number, sums): &(u32, Sums)| stats(sums).as_frame(*number, header.warmup.contains(number), sums.answered);
    Ok(MachineStats {
        accuracy: Accuracy::Bounded,
        frames: bound.frames.iter().map(frame).collect(),
        bounds: Some(bound.bounds(&header.warmup)),
        oracle: Some(Limit { cycles: limit.cycles.least, dram_bytes: limit.dram_bytes.least }),
        ..stats(&bound.sum(&header.warmup))
    })
}
