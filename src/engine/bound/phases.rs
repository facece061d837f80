//! Frames and their ends follow one another: each is a phase, and the bounds of phases add up.

use super::steps::{StepWork, Steps};
use crate::engine::error::RunError;
use crate::engine::items::ItemStream;
use crate::engine::source::parents;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::memory::dram::part::Timing;
use crate::memory::dram::spec::Model;
use crate::quantity::{Bytes, Cycle};
use crate::stats::{Accuracy, Bounds, Cause, Limit, MachineStats, Range, TrafficClass};
use crate::stream::{Chunk, Decision, Header, Item, RayKind};

/// Adds up a stream's bounds.
#[derive(Clone, Debug)]
pub struct Bound {
    machine: MachineSpec,
    /// Whether all shadow rays' answers are known for nothing.
    oracle: bool,
    steps: StepWork,
    // Of the phase.
    rays: u64,
    pool_held: u64,
    slots_held: u64,
    longest: u64,
    // Of the run.
    cycles: u64,
    serial: u64,
    traced: u64,
    primitives: u64,
}

impl Bound {
    /// Bounds of a stream that has not begun.
    pub fn new(machine: &MachineSpec, header: &Header, oracle: bool) -> Self {
        Self {
            oracle,
            steps: StepWork::new(machine, header),
            rays: 0,
            pool_held: 0,
            slots_held: 0,
            longest: 0,
            cycles: 0,
            serial: 0,
            traced: 0,
            primitives: header.primitives.into(),
            machine: machine.clone(),
        }
    }

    /// The stream's next item. What is wrong with it is for others to find.
    pub fn add(&mut self, item: &Item) {
        match item {
            Item::Frame(info) => {
                self.steps.begin_frame(info);
                // A sweep sets words and counters of all.
                self.steps.left_out += 2 * self.primitives;
            }
            Item::Rays(chunk) => self.chunk(chunk),
            Item::End { policy, .. } => {
                self.end_phase();
                for word in policy.chunks(1) {
                    let held = self.steps.add(word, Steps::Policy);
                    self.steps.work[Kind::ShadowCache as usize].held += held;
                    self.longest = self.longest.max(held);
                }
                self.end_phase();
            }
        }
    }

    fn chunk(&mut self, chunk: &Chunk) {
        let Ok(parents) = parents(chunk) else { return };
        let (latency, shading) = (self.machine.dispatcher.latency.get(), self.machine.dispatcher.shading_cycles.get());
        // From the first hand-over of a ray's group to the ray being done, at least.
        let mut done = vec![0; chunk.len()];
        for (index, ray) in chunk.rays().enumerate() {
            let known = self.oracle && ray.head.kind == RayKind::Shadow;
            let skipped = known || ray.head.decision == Decision::Skip;
            let mut slot = if skipped { 0 } else { latency };
            let mut policy = 0;
            if !skipped {
                let steps = if ray.head.kind == RayKind::Shadow { Steps::ShadowPath } else { Steps::Path };
                slot += self.steps.add(ray.packed_path(), steps);
                self.slots_held += slot;
                self.traced += 1;
            }
            let spec = &self.machine.shadow_cache;
            let performed = ray.packed_policy().iter().filter(|&&word| spec.performs(word));
            if !known && spec.decide.answers(ray.head.decision, performed.count()) {
                done[index] = done[parents[index] as usize] + shading;
                self.longest = self.longest.max(done[index]);
                continue;
            }
            if !known && spec.decide.takes_an_operation(ray.head.decision) {
                policy += self.steps.kinds[Kind::ShadowCache as usize].latency;
                self.steps.decide();
            }
            if !known {
                let kept = ray.packed_policy().split(|&word| spec.silent.drops(word));
                policy += kept.map(|words| self.steps.add(words, Steps::Policy)).sum::<u64>();
                self.steps.work[Kind::ShadowCache as usize].held += policy;
                self.rays += 1;
                self.pool_held += slot + policy;
            }
            let parent = parents[index] as usize;
            done[index] = slot + policy + if parent == index { 0 } else { done[parent] + shading };
            self.longest = self.longest.max(done[index]);
            // One thing after another: a few cycles from part to part beside what was counted.
            self.serial += slot + policy + latency + shading + 16;
        }
    }

    /// All rays of a frame, or all steps of its end, are known: none of what follows can overlap them.
    fn end_phase(&mut self) {
        self.steps.settle();
        let mut least = self.longest;
        let StepWork { kinds, work, lines, divisions, .. } = &self.steps;
        let mut at_least = |work: u64, rate: u64| least = least.max(work.div_ceil(rate));
        let (cores, division) = (self.machine.cores.get(), &self.machine.division);
        at_least(self.rays, cores * self.machine.dispatcher.per_cycle.get());
        at_least(self.pool_held, self.machine.pool());
        at_least(self.slots_held, self.machine.traversal.rays.get() * kinds[Kind::Traversal as usize].count);
        at_least(divisions * division.interval.get(), cores * division.count.get());
        for (unit, work) in kinds.iter().zip(work) {
            at_least(work.operations * unit.interval, unit.count * unit.width);
            at_least(work.accesses, unit.count * unit.cache.accesses_per_cycle());
            if let Some(contexts) = unit.contexts {
                at_least(work.held, unit.count * contexts);
            }
        }
        lines.banks.iter().for_each(|&requests| at_least(requests, cores));
        if let Some((bytes, cycles)) = self.machine.dram.channel_peak(self.machine.clock_mhz.get()) {
            let line = self.machine.line_bytes.get();
            lines.channels.iter().for_each(|&lines| at_least(lines * line * cycles / bytes, 1));
        }
        self.cycles += least;
        (self.rays, self.pool_held, self.slots_held, self.longest) = (0, 0, 0, 0);
        self.steps.end_phase();
    }

    /// The bounds of what was added.
    pub fn bounds(&self) -> Bounds {
        let line = self.machine.line_bytes.get();
        let StepWork { work, lines, writes, left_out, stores_count, .. } = &self.steps;
        let accesses: u64 = work.iter().map(|work| work.all_accesses).sum();
        let sum = |bytes: &[Bytes]| bytes.iter().copied().sum::<Bytes>();
        // An access fetches its line; a write may have to be written back, to a line that must be fetched for it.
        let more = if *stores_count { 0 } else { 2 * left_out };
        let (accesses, writes) = (accesses + more, writes + more);
        let l2 = Bytes((accesses + writes) * line);
        let dram = Bytes((accesses + 3 * writes) * line);
        Bounds {
            cycles: Range { least: Cycle(self.cycles), most: Cycle(self.serial_cycles(dram.0 / line)) },
            l2_bytes: Range { least: sum(&lines.l2), most: l2 },
            dram_bytes: Range { least: sum(&lines.dram), most: dram },
        }
    }

    /// Cycles of everything one after another, with `requests` to the DRAM, each of which waits for all that may come before it.
    fn serial_cycles(&self, requests: u64) -> u64 {
        let StepWork { kinds, work, left_out, stores_count, .. } = &self.steps;
        let operations: u64 = kinds
            .iter()
            .zip(work)
            .map(|(unit, work)| work.all_operations * (unit.latency + 8) + work.all_accesses * unit.cache.latency.get())
            .sum();
        let left_out = if *stores_count { 0 } else { 2 * left_out };
        let unit = &kinds[Kind::ShadowCache as usize];
        let operations = operations + left_out * (unit.latency + unit.cache.latency.get() + 16);
        let l2 = self.machine.l2.caches().iter().map(|(_, cache)| cache.latency.get()).max().unwrap_or(0);
        let served = |request| self.serial + operations + requests * (request + 2 * l2 + 16) + 1000;
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
        // Of the time between refreshes more than half can be used: the spec's check sees to it.
        2 * served(request) + 2 * clocks.cycle_after(refi.get() + rfc.get())
    }

    /// The lower bound as what a machine would have measured that meets it.
    fn stats(&self) -> MachineStats {
        let machine = &self.machine;
        let present = |bytes: &[Bytes]| {
            let all = TrafficClass::ALL.into_iter().zip(bytes.iter().copied());
            all.filter(|(_, bytes)| bytes.0 > 0).collect()
        };
        let mut stats = MachineStats {
            cycles: Cycle(self.cycles),
            clock_mhz: machine.clock_mhz.get() as f64,
            rays: self.traced,
            dram_organization: machine.dram.to_string(),
            dram_peak_bytes_per_cycle: machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get()),
            ..MachineStats::default()
        };
        let StepWork { kinds, work, lines, requested, .. } = &self.steps;
        stats.dram.reads = lines.first_touches;
        for (home, (name, _)) in machine.l2.caches().into_iter().enumerate() {
            let mut here = lines.l2;
            let elsewhere = TrafficClass::ALL.into_iter().filter(|&class| machine.l2.home(class) != home);
            elsewhere.for_each(|class| here[class as usize] = Bytes(0));
            stats.bytes.insert(name, present(&here));
        }
        stats.bytes.insert("dram".into(), present(&lines.dram));
        for ((kind, unit), work) in Kind::ALL.into_iter().zip(kinds).zip(work) {
            let (name, level) = kind.names();
            stats.bytes.insert(level.into(), present(&requested[kind as usize]));
            let busy = (work.all_operations * unit.interval).div_ceil(unit.width);
            stats.units.insert(name.into(), [(Cause::Busy, busy)].into());
            stats.unit_counts.insert(name.into(), unit.count);
        }
        stats
    }
}

/// The `Bound` rung: what no machine can beat on this stream, and on one whose shadow rays' answers are all known.
pub fn run(machine: &MachineSpec, header: &Header, items: &mut ItemStream<'_>) -> Result<MachineStats, RunError> {
    let (mut bound, mut oracle) = (Bound::new(machine, header, false), Bound::new(machine, header, true));
    for item in items {
        let item = item?;
        bound.add(&item);
        oracle.add(&item);
    }
    let limit = oracle.bounds();
    Ok(MachineStats {
        accuracy: Accuracy::Bounded,
        bounds: Some(bound.bounds()),
        oracle: Some(Limit { cycles: limit.cycles.least, dram_bytes: limit.dram_bytes.least }),
        ..bound.stats()
    })
}
