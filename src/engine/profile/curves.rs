//! Misses of caches of all sizes at once, from the reuse distances of the requests to each cache of a machine.

use std::sync::Arc;

use rustc_hash::FxHashSet;

use super::watch::Watch;
use crate::engine::work::{Holder, Work};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::layout::{Element, Layout};
use crate::memory::paged::Paged;
use crate::memory::reuse::{Sample, Sampled, Stack};
use crate::quantity::LineAddr;
use crate::stats::{ReuseCurve, ReuseLevel, TrafficClass};
use crate::stream::{Header, Item, RayKind, Step};

/// Distances by their number of bits: a cache of `2^n` lines hits distances of up to `n` bits.
const BITS: usize = 33;

#[derive(Clone, Debug)]
enum Distances {
    Exact(Stack),
    Sampled(Sample),
}

impl Distances {
    fn touch(&mut self, line: u32) -> Option<Sampled> {
        match self {
            Self::Exact(stack) => {
                Some(Sampled { distance: stack.touch(line, 0).map(|[distance]| distance), weight: 1.0 })
            }
            Self::Sampled(sample) => sample.touch(line),
        }
    }

    fn drop_from(&mut self, first: u32) {
        match self {
            Self::Exact(stack) => stack.drop_from(first),
            Self::Sampled(sample) => sample.drop_from(first),
        }
    }
}

/// Results of a class's accesses.
#[derive(Clone, Copy, Debug)]
struct Met {
    accesses: u64,
    first: f64,
    by_bits: [f64; BITS],
    in_sets: f64,
}

/// The first touch of a line in a cache.
#[derive(Clone, Copy, Debug)]
struct First {
    cache: usize,
    line: u32,
    class: TrafficClass,
    weight: f64,
}

/// The caches of a level.
#[derive(Clone, Debug)]
struct Level {
    name: String,
    caches: Vec<Distances>,
    /// First touches of the frame, in order.
    firsts: Vec<First>,
    bytes: u64,
    ways: u64,
    /// By distance, the probability that a set of the cache in its present size still holds the line.
    held: Vec<f64>,
    met: [Met; TrafficClass::ALL.len()],
}

impl Level {
    fn new(name: String, caches: usize, bytes: u64, ways: u64, line: u64, distances: &Distances) -> Self {
        let nothing = Met { accesses: 0, first: 0.0, by_bits: [0.0; BITS], in_sets: 0.0 };
        Self {
            name,
            caches: vec![distances.clone(); caches],
            firsts: Vec::new(),
            bytes,
            ways,
            held: held((bytes / (line * ways)).max(1), ways),
            met: [nothing; TrafficClass::ALL.len()],
        }
    }

    fn touch(&mut self, cache: usize, line: LineAddr, class: TrafficClass) {
        self.met[class as usize].accesses += 1;
        let line = line.0 as u32;
        let Some(Sampled { distance, weight }) = self.caches[cache].touch(line) else { return };
        match distance {
            None => {
                self.met[class as usize].first += weight;
                self.firsts.push(First { cache, line, class, weight });
            }
            Some(distance) => self.reused(distance, class, weight),
        }
    }

    fn reused(&mut self, distance: u64, class: TrafficClass, weight: f64) {
        let met = &mut self.met[class as usize];
        met.by_bits[(u64::BITS - distance.leading_zeros()) as usize] += weight;
        met.in_sets += weight * self.held.get(distance as usize).copied().unwrap_or(0.0);
    }

    fn drop_from(&mut self, first: LineAddr) {
        self.firsts.clear();
        self.caches.iter_mut().for_each(|cache| cache.drop_from(first.0 as u32));
    }

    /// See [`Curves::repeat`]. Two kinds of lines lie between a line's last touch and its first touch in the
    /// repetition: lines touched after that last touch, and lines whose first touch precedes the line's first touch.
    fn repeat(&mut self, dropped: LineAddr) {
        let firsts = std::mem::take(&mut self.firsts);
        self.drop_from(dropped);
        for First { cache, line, class, weight } in firsts {
            let touched = self.caches[cache].touch(line);
            if let Some(distance) = touched.and_then(|it| it.distance) {
                self.met[class as usize].first -= weight;
                self.reused(distance, class, weight);
            }
        }
    }

    fn curves(&self, line: u64) -> ReuseLevel {
        let curve = |met: &Met| {
            let hits = |size: u64| met.by_bits[..=(size / line).ilog2() as usize].iter().sum::<f64>();
            let sampled: f64 = met.first + met.by_bits.iter().sum::<f64>();
            ReuseCurve {
                accesses: met.accesses,
                sampled,
                first_touches: met.first,
                misses: ReuseCurve::sizes().map(|size| sampled - hits(size)).collect(),
                misses_in_sets: sampled - met.in_sets,
            }
        };
        let classes = TrafficClass::ALL.into_iter().zip(&self.met).filter(|(_, met)| met.accesses > 0);
        ReuseLevel {
            name: self.name.clone(),
            caches: self.caches.len() as u64,
            bytes: self.bytes,
            ways: self.ways,
            classes: classes.map(|(class, met)| (class, curve(met))).collect(),
        }
    }
}

/// By distance `d`, the probability that fewer than `ways` of `d` other lines map to the line's own set of `sets` sets
/// (Smith 1978; Hill and Smith 1989). Ends where the probability is negligible.
fn held(sets: u64, ways: u64) -> Vec<f64> {
    let into = 1.0 / sets as f64;
    // The probability that 0, 1, ... of the lines so far map to the set.
    let mut fell = vec![0.0; ways as usize];
    fell[0] = 1.0;
    let mut held = Vec::new();
    loop {
        let sum: f64 = fell.iter().sum();
        if sum < 1e-9 {
            return held;
        }
        held.push(sum);
        for count in (0..fell.len()).rev() {
            let before = if count > 0 { fell[count - 1] } else { 0.0 };
            fell[count] = fell[count] * (1.0 - into) + before * into;
        }
    }
}

/// Watches all caches of a machine. Each cache gets the requests of the machine's caches above it.
#[derive(Clone, Debug)]
pub(crate) struct Curves {
    line: u64,
    /// L1s by kind, then the caches of the L2.
    levels: Vec<Level>,
    /// For each unit of the machine: its kind and its number in that kind.
    units: Vec<(usize, usize)>,
    homes: [usize; TrafficClass::ALL.len()],
    /// Lines from here on are new in every frame.
    dropped: LineAddr,
}

impl Curves {
    /// The caches of `machine`. With `sample`: a share of the lines, and the lines of the given set.
    pub(crate) fn new(machine: &MachineSpec, sample: Option<(f64, Arc<FxHashSet<u32>>)>) -> Self {
        let line = machine.line_bytes.get();
        let distances = match sample {
            None => Distances::Exact(Stack::default()),
            Some((rate, hot)) => Distances::Sampled(Sample::new(rate, hot)),
        };
        let (mut levels, mut units) = (Vec::new(), Vec::new());
        for (index, kind) in Kind::ALL.into_iter().enumerate() {
            let (spec, name) = (kind.spec(machine), kind.names().1.to_owned());
            units.extend((0..spec.count as usize).map(|unit| (index, unit)));
            let (bytes, ways) = (spec.cache.bytes.get(), spec.cache.ways.get());
            levels.push(Level::new(name, spec.count as usize, bytes, ways, line, &distances));
        }
        for (name, cache) in machine.l2.caches() {
            let (bytes, ways) = (cache.bytes.get(), cache.ways.get());
            levels.push(Level::new(name, machine.cores.size(), bytes, ways, line, &distances));
        }
        let homes = TrafficClass::ALL.map(|class| Kind::ALL.len() + machine.l2.home(class));
        Self { line, levels, units, homes, dropped: LineAddr(u64::from(u32::MAX)) }
    }

    /// Treats the frame as one of many equal frames: a line's first touch follows its last touch in the previous frame.
    pub(crate) fn repeat(&mut self) {
        let dropped = self.dropped;
        self.levels.iter_mut().for_each(|level| level.repeat(dropped));
    }

    /// The curves of all levels with accesses.
    pub(crate) fn levels(&self) -> Vec<ReuseLevel> {
        self.levels.iter().map(|level| level.curves(self.line)).filter(|level| !level.classes.is_empty()).collect()
    }
}

impl Watch for Curves {
    fn l1(&mut self, unit: usize, line: LineAddr, class: TrafficClass) {
        let (level, cache) = self.units[unit];
        self.levels[level].touch(cache, line, class);
    }

    fn l2(&mut self, core: usize, line: LineAddr, class: TrafficClass) {
        self.levels[self.homes[class as usize]].touch(core, line, class);
    }

    fn drop_from(&mut self, first: LineAddr) {
        self.dropped = first;
        self.levels.iter_mut().for_each(|level| level.drop_from(first));
    }
}

/// How often a stream accesses each line.
#[derive(Clone, Debug)]
pub(crate) struct Heat {
    layout: Layout,
    touches: Paged<u32>,
}

impl Heat {
    /// The counters of a stream before it begins.
    pub(crate) fn new(machine: &MachineSpec, header: &Header) -> Self {
        Self { layout: Layout::new(header, machine), touches: Paged::new(0) }
    }

    /// Counts the stream's next item.
    pub(crate) fn add(&mut self, item: &Item) {
        match item {
            Item::Frame(info) => self.layout.begin_frame(info),
            Item::Rays(chunk) => {
                for ray in chunk.rays() {
                    ray.path().for_each(|step| self.step(step, Holder::Traversal, ray.head.kind));
                    ray.policy().for_each(|step| self.step(step, Holder::ShadowCache, ray.head.kind));
                }
            }
            Item::End { policy, .. } => {
                Step::unpack_all(policy).for_each(|step| self.step(step, Holder::ShadowCache, RayKind::Primary));
            }
        }
    }

    fn step(&mut self, step: Step, holder: Holder, ray: RayKind) {
        let work = Work::of(step, holder, ray, &self.layout);
        self.touch(&work.first);
        work.second.iter().for_each(|second| self.touch(second));
    }

    fn touch(&mut self, element: &Element) {
        let touches = self.touches.at(self.layout.lines(element).0.0 as usize);
        *touches = touches.saturating_add(1);
    }

    /// The `count` lines with the most accesses; among equals the lowest numbers.
    pub(crate) fn hottest(mut self, count: usize) -> Arc<FxHashSet<u32>> {
        let touched = self.touches.from(0).filter(|(_, touches)| **touches > 0);
        let mut lines: Vec<(u32, u32)> = touched.map(|(line, &mut touches)| (line as u32, touches)).collect();
        lines.sort_by_key(|&(_, touches)| std::cmp::Reverse(touches));
        Arc::new(lines.into_iter().take(count).map(|(line, _)| line).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_hold_what_the_binomial_law_says() {
        assert_eq!(held(1, 4), [1.0; 4]);
        assert_eq!(held(4, 1)[..3], [1.0, 0.75, 0.5625]);
        assert_eq!(held(2, 2)[..4], [1.0, 1.0, 0.75, 0.5]);
    }

    /// A repeated frame has the reuse of the second of two equal frames.
    #[test]
    fn a_repeated_frame_has_the_reuse_of_the_next_one() {
        let class = TrafficClass::Node;
        let level = || Level::new("l2".into(), 2, 1024, 4, 64, &Distances::Exact(Stack::default()));
        let turn = |level: &mut Level| {
            let touches = (0..500u64).map(|at| (at as usize % 2, LineAddr((at * at * 31 + at * 7919) % 97 % 90)));
            touches.for_each(|(cache, line)| level.touch(cache, line, class));
        };
        let (mut repeated, mut once, mut twice) = (level(), level(), level());
        [&mut repeated, &mut once, &mut twice].into_iter().for_each(turn);
        turn(&mut twice);
        repeated.repeat(LineAddr(1000));
        let met = |level: &Level| level.met[class as usize];
        let second = (0..BITS).map(|bits| met(&twice).by_bits[bits] - met(&once).by_bits[bits]);
        assert_eq!(met(&repeated).by_bits.to_vec(), second.collect::<Vec<_>>());
        assert_eq!((met(&repeated).first, met(&once).first), (0.0, met(&twice).first));
    }
}
