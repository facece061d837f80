//! Bounds that no machine of a spec can beat on a stream, in closed form: what must be done at least, over what can be done a
//! cycle at most. And an upper bound: everything missed, one thing after another.
//!
//! Frames and their ends follow one another, so their bounds add up.

use std::ops::AddAssign;

use super::error::RunError;
use super::items::ItemStream;
use super::tally::PerClass;
use super::work::{Holder, Work, stores_as_recorded};
use crate::energy;
use crate::engine::source::parents;
use crate::machine::MachineSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::machine::layout::{Element, Layout};
use crate::memory::dram::part::Timing;
use crate::memory::dram::spec::Model;
use crate::memory::l2::Home;
use crate::memory::tags::Contents;
use crate::quantity::{Bytes, Cycle, LineAddr};
use crate::stats::{Accuracy, Bounds, Cause, Limit, MachineStats, Range, TrafficClass};
use crate::stream::{Chunk, Decision, Header, Item, RayKind, Step};

/// Lines that were touched.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines(Vec<u64>);

impl Lines {
    /// Touches a line; whether it is the first time.
    #[inline]
    pub(super) fn touch(&mut self, line: u64) -> bool {
        let word = (line / 64) as usize;
        if word >= self.0.len() {
            self.0.resize(word + 1, 0);
        }
        let (bit, word) = (1 << (line % 64), &mut self.0[word]);
        let new = *word & bit == 0;
        *word |= bit;
        new
    }

    /// Forgets lines from `first` on.
    pub(super) fn forget_from(&mut self, first: u64) {
        let word = (first / 64) as usize;
        self.0.truncate(word + 1);
        if let Some(last) = self.0.get_mut(word) {
            *last &= (1 << (first % 64)) - 1;
        }
    }
}

/// What is counted of a kind of units in a phase: operations, accesses to lines, cycles that rays hold contexts at least.
#[derive(Clone, Copy, Debug, Default)]
struct KindWork {
    operations: u64,
    accesses: u64,
    held: u64,
}

/// What is added up over frames.
#[derive(Clone, Debug, Default)]
struct Sums {
    cycles: u64,
    serial: u64,
    traced: u64,
    answered: u64,
    first_touches: u64,
    writes: u64,
    /// Steps of stores that are left out of what must be done.
    left_out: u64,
    operations: [u64; Kind::ALL.len()],
    accesses: [u64; Kind::ALL.len()],
    requested: [PerClass<Bytes>; Kind::ALL.len()],
    l2: PerClass<Bytes>,
    dram: PerClass<Bytes>,
}

impl AddAssign<&Sums> for Sums {
    fn add_assign(&mut self, other: &Self) {
        self.cycles += other.cycles;
        self.serial += other.serial;
        self.traced += other.traced;
        self.answered += other.answered;
        self.first_touches += other.first_touches;
        self.writes += other.writes;
        self.left_out += other.left_out;
        add_each(&mut self.operations, &other.operations);
        add_each(&mut self.accesses, &other.accesses);
        self.requested.iter_mut().zip(&other.requested).for_each(|(sum, other)| add_each(sum, other));
        add_each(&mut self.l2, &other.l2);
        add_each(&mut self.dram, &other.dram);
    }
}

fn add_each<T: AddAssign + Copy>(sums: &mut [T], others: &[T]) {
    sums.iter_mut().zip(others).for_each(|(sum, &other)| *sum += other);
}

/// Adds up a stream's bounds.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    machine: MachineSpec,
    kinds: [KindSpec; Kind::ALL.len()],
    layout: Layout,
    /// Whether all shadow rays' answers are known for nothing.
    oracle: bool,
    /// Lines that each kind of units touched, and that any did.
    touched: [Lines; Kind::ALL.len()],
    touched_by_any: Lines,
    work: [KindWork; Kind::ALL.len()],
    // Of the phase.
    rays: u64,
    divisions: u64,
    pool_held: u64,
    slots_held: u64,
    longest: u64,
    banks: Vec<u64>,
    homes: [Home; TrafficClass::ALL.len()],
    /// Whether the L2's cache for a class is ideal.
    ideal_homes: [bool; TrafficClass::ALL.len()],
    channels: Vec<u64>,
    /// Whether steps of stores are performed as recorded; else they are left out of what must be done, and may be done.
    stores_count: bool,
    primitives: u64,
    /// The frame under way, and those that are over.
    frame: Sums,
    number: u32,
    frames: Vec<(u32, Sums)>,
}

impl Bound {
    /// Bounds of a stream that has not begun.
    pub(super) fn new(machine: &MachineSpec, header: &Header, oracle: bool) -> Self {
        Self {
            kinds: Kind::ALL.map(|kind| kind.spec(machine)),
            layout: Layout::new(header, machine),
            oracle,
            touched: Default::default(),
            touched_by_any: Lines::default(),
            work: Default::default(),
            rays: 0,
            divisions: 0,
            pool_held: 0,
            slots_held: 0,
            longest: 0,
            banks: vec![0; machine.l2.banks() as usize],
            homes: machine.l2.homes(),
            ideal_homes: TrafficClass::ALL
                .map(|class| machine.l2.caches()[machine.l2.home(class)].1.contents == Contents::Ideal),
            channels: vec![0; machine.dram.channels.size()],
            stores_count: stores_as_recorded(machine),
            primitives: header.primitives.into(),
            frame: Sums::default(),
            number: 0,
            frames: Vec::new(),
            machine: machine.clone(),
        }
    }

    /// The stream's next item. What is wrong with it is for others to find.
    pub(super) fn add(&mut self, item: &Item) {
        match item {
            Item::Frame(info) => {
                self.layout.begin_frame(info);
                // A sweep sets words and counters of all.
                self.frame.left_out += 2 * self.primitives;
                self.number = info.number;
                let first = self.layout.dynamic_part().0;
                self.touched.iter_mut().for_each(|lines| lines.forget_from(first));
                self.touched_by_any.forget_from(first);
            }
            Item::Rays(chunk) => self.chunk(chunk),
            Item::End { policy, .. } => {
                self.end_phase();
                for step in policy.iter().filter_map(|&word| Step::unpack(word)) {
                    let held = self.step(step, Holder::ShadowCache, RayKind::Primary);
                    self.work[Kind::ShadowCache as usize].held += held;
                    self.longest = self.longest.max(held);
                }
                self.end_phase();
                self.frames.push((self.number, std::mem::take(&mut self.frame)));
            }
        }
    }

    fn chunk(&mut self, chunk: &Chunk) {
        let Ok(parents) = parents(chunk) else { return };
        let (latency, shading) = (self.machine.dispatcher.latency.get(), self.machine.dispatcher.shading_cycles.get());
        // From the first hand-over of a ray's group to the ray being done, at least.
        let mut done = vec![0; chunk.len()];
        for (index, ray) in chunk.rays().enumerate() {
            self.frame.answered += 1;
            let known = self.oracle && ray.head.kind == RayKind::Shadow;
            let skipped = known || ray.head.decision == Decision::Skip;
            let mut slot = if skipped { 0 } else { latency };
            let mut policy = 0;
            if !skipped {
                let steps = ray.packed_path().iter().filter_map(|&word| Step::unpack(word));
                slot += steps.map(|step| self.step(step, Holder::Traversal, ray.head.kind)).sum::<u64>();
                self.slots_held += slot;
                self.frame.traced += 1;
            }
            let spec = &self.machine.shadow_cache;
            let performed = ray.packed_policy().iter().filter(|&&word| spec.performs(word));
            if !known && spec.decide.answers(ray.head.decision, performed.count()) {
                done[index] = done[parents[index] as usize] + shading;
                self.longest = self.longest.max(done[index]);
                continue;
            }
            if !known && spec.decide.takes_an_operation(ray.head.decision) {
                let unit = &self.kinds[Kind::ShadowCache as usize];
                policy += unit.latency;
                self.work[Kind::ShadowCache as usize].operations += 1;
                self.frame.operations[Kind::ShadowCache as usize] += 1;
            }
            if !known {
                let spec = self.machine.shadow_cache;
                let steps = ray.packed_policy().iter().filter(|&&word| !spec.silent.drops(word));
                let steps = steps.filter_map(|&word| Step::unpack(word));
                policy += steps.map(|step| self.step(step, Holder::ShadowCache, ray.head.kind)).sum::<u64>();
                self.work[Kind::ShadowCache as usize].held += policy;
                self.rays += 1;
                self.pool_held += slot + policy;
            }
            let parent = parents[index] as usize;
            done[index] = slot + policy + if parent == index { 0 } else { done[parent] + shading };
            self.longest = self.longest.max(done[index]);
            // One thing after another: a few cycles from part to part beside what was counted.
            self.frame.serial += slot + policy + latency + shading + 16;
        }
    }

    /// Counts a step; cycles that it takes at least.
    fn step(&mut self, step: Step, holder: Holder, ray: RayKind) -> u64 {
        if step.entry().is_some() && !self.stores_count {
            // Learned bits may be read and taken over beside it.
            self.frame.left_out += 3;
            return 0;
        }
        let work = Work::of(step, holder, ray, &self.layout);
        let unit = &self.kinds[work.kind as usize];
        let operations = work.operations();
        // An access to a line that is about to come has its data a cycle later, however long a hit takes.
        let access = match unit.cache.contents {
            Contents::Tags => 1,
            Contents::Ideal => unit.cache.latency.get(),
        };
        let mut held = operations * (access + unit.latency);
        if work.divides {
            held += self.machine.division.latency.get();
            self.divisions += 1;
        }
        self.work[work.kind as usize].operations += operations;
        self.frame.operations[work.kind as usize] += operations;
        self.touch(work.kind, &work.first);
        if let Some(second) = &work.second {
            self.touch(work.kind, second);
        }
        if matches!(work.kind, Kind::List | Kind::Intersection) {
            self.work[work.kind as usize].held += held;
        }
        if work.kind == Kind::Intersection {
            // There and back; of a list entry the way on is that of its triangle.
            held += 2;
        }
        held
    }

    fn touch(&mut self, kind: Kind, element: &Element) {
        let (first, lines) = self.layout.lines(element);
        let (class, size) = (element.class as usize, Bytes(self.machine.line_bytes.get()));
        self.frame.requested[kind as usize][class] += Bytes(element.bytes);
        self.work[kind as usize].accesses += lines;
        self.frame.accesses[kind as usize] += lines;
        self.frame.writes += u64::from(element.write) * lines;
        if self.kinds[kind as usize].cache.contents == Contents::Ideal {
            return;
        }
        let l2_is_ideal = self.ideal_homes[class];
        for line in first.0..first.0 + lines {
            if self.touched[kind as usize].touch(line) {
                self.banks[self.homes[class].bank(LineAddr(line))] += 1;
                self.frame.l2[class] += size;
                if !l2_is_ideal && self.touched_by_any.touch(line) {
                    let place = self.machine.dram.place(LineAddr(line));
                    self.channels[place.channel] += 1;
                    self.frame.dram[class] += size;
                    self.frame.first_touches += 1;
                }
            }
        }
    }

    /// All rays of a frame, or all steps of its end, are known: none of what follows can overlap them.
    fn end_phase(&mut self) {
        let mut least = self.longest;
        let mut at_least = |work: u64, rate: u64| least = least.max(work.div_ceil(rate));
        let (cores, division) = (self.machine.cores.get(), &self.machine.division);
        at_least(self.rays, cores * self.machine.dispatcher.per_cycle.get());
        at_least(self.pool_held, self.machine.pool());
        at_least(self.slots_held, self.machine.traversal.rays.get() * self.kinds[Kind::Traversal as usize].count);
        at_least(self.divisions * division.interval.get(), cores * division.count.get());
        for (unit, work) in self.kinds.iter().zip(&self.work) {
            at_least(work.operations * unit.interval, unit.count * unit.width);
            at_least(work.accesses, unit.count * unit.cache.accesses_per_cycle());
            if let Some(contexts) = unit.contexts {
                at_least(work.held, unit.count * contexts);
            }
        }
        self.banks.iter().for_each(|&requests| at_least(requests, cores));
        if let Some((bytes, cycles)) = self.machine.dram.channel_peak(self.machine.clock_mhz.get()) {
            let line = self.machine.line_bytes.get();
            self.channels.iter().for_each(|&lines| at_least(lines * line * cycles / bytes, 1));
        }
        self.frame.cycles += least;
        self.divisions = 0;
        (self.rays, self.pool_held, self.slots_held, self.longest) = (0, 0, 0, 0);
        for work in &mut self.work {
            (work.operations, work.accesses, work.held) = (0, 0, 0);
        }
        self.banks.fill(0);
        self.channels.fill(0);
    }

    /// The sum of the frames that are not among `left_out`.
    fn sum(&self, left_out: &[u32]) -> Sums {
        let mut sum = Sums::default();
        self.frames.iter().filter(|(frame, _)| !left_out.contains(frame)).for_each(|(_, frame)| sum += frame);
        sum
    }

    /// The bounds of all frames but those of `warmup`. A line that no frame touched before is fetched in any case; a line
    /// that was written in a frame of `warmup` may be written back later.
    pub(super) fn bounds(&self, warmup: &[u32]) -> Bounds {
        let (measured, all) = (self.sum(warmup), self.sum(&[]));
        let line = self.machine.line_bytes.get();
        let bytes = |bytes: &PerClass<Bytes>| bytes.iter().copied().sum::<Bytes>();
        // An access fetches its line; a write may have to be written back, to a line that must be fetched for it.
        let left_out = if self.stores_count { 0 } else { 2 * all.left_out };
        let (accesses, writes) = (measured.accesses.iter().sum::<u64>() + left_out, all.writes + left_out);
        let l2 = Bytes((accesses + writes) * line);
        let dram = Bytes((accesses + 3 * writes) * line);
        let most = self.serial_cycles(&measured, left_out, dram.0 / line);
        Bounds {
            cycles: Range { least: Cycle(measured.cycles), most: Cycle(most) },
            l2_bytes: Range { least: bytes(&measured.l2), most: l2 },
            dram_bytes: Range { least: bytes(&measured.dram), most: dram },
        }
    }

    /// Cycles of everything one after another, with `requests` to the DRAM, each of which waits for all that may come before it.
    fn serial_cycles(&self, sums: &Sums, left_out: u64, requests: u64) -> u64 {
        let operations: u64 = self
            .kinds
            .iter()
            .zip(sums.operations.iter().zip(&sums.accesses))
            .map(|(unit, (operations, accesses))| operations * (unit.latency + 8) + accesses * unit.cache.latency.get())
            .sum();
        let unit = &self.kinds[Kind::ShadowCache as usize];
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
        // Of the time between refreshes more than half can be used: the spec's check sees to it.
        2 * served(request) + 2 * clocks.cycle_after(refi.get() + rfc.get())
    }

    /// The lower bound as what a machine would have measured that meets it.
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
        stats.dram.reads = sums.first_touches;
        for (home, (name, _)) in machine.l2.caches().into_iter().enumerate() {
            let mut here = sums.l2;
            let elsewhere = TrafficClass::ALL.into_iter().filter(|&class| machine.l2.home(class) != home);
            elsewhere.for_each(|class| here[class as usize] = Bytes(0));
            stats.bytes.insert(name, present(&here));
        }
        stats.bytes.insert("dram".into(), present(&sums.dram));
        for (kind, unit) in Kind::ALL.into_iter().zip(&self.kinds) {
            let (name, level) = kind.names();
            stats.bytes.insert(level.into(), present(&sums.requested[kind as usize]));
            let busy = (sums.operations[kind as usize] * unit.interval).div_ceil(unit.width);
            stats.units.insert(name.into(), [(Cause::Busy, busy)].into());
            stats.unit_counts.insert(name.into(), unit.count);
        }
        stats
    }
}

/// The `Bound` rung: what no machine can beat on this stream, and on one whose shadow rays' answers are all known.
pub(super) fn run(
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
