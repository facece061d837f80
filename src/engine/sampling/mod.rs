//! Sampling: of each stratum of consecutive windows (runs of pixels of about the same number of rays) two are replayed and
//! measured, each behind a window of warm-up; what the others touch is recorded, so that the L2 holds what it would.

pub mod estimate;
pub mod figures;
mod recency;

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::Arc;

use self::estimate::{KNOWN, Population, Window};
use self::recency::Recency;
use super::RunError;
use super::feed::Feed;
use super::tally::Tally;
use super::work::Kind;
use crate::machine::MachineSpec;
use crate::machine::source::FrameCounts;
use crate::memory::Touch;
use crate::memory::tags::Contents;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::{Chunk, Decision, Header, Item, RayKind, Step, Totals};

/// How much is replayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Windows a stratum; of each, two are measured.
    pub stratum: usize,
    /// Rays of a window, at least.
    pub rays: usize,
    /// Windows of warm-up before each that is measured.
    pub warm_up: usize,
    /// Which windows: by a hash of this and the stratum's number.
    pub seed: u64,
}

impl Plan {
    /// The plan that measures about `rate` of the windows of a stream on `machine`.
    pub fn new(rate: f64, machine: &MachineSpec, seed: u64) -> Self {
        let stratum = (2.0 / rate).round().max(2.0) as usize;
        // Rays that are in flight at a window's ends are in part its neighbours': they are to be few.
        let rays = (4 * machine.dispatcher.rays.size()).max(512);
        // In the warm-up each line of the L1s of a kind can be replaced by one ray in each.
        let lines = |kind: Kind| {
            let spec = kind.spec(machine);
            match spec.cache.contents {
                Contents::Tags => (spec.count * spec.cache.bytes.get() / machine.line_bytes.get()) as usize,
                Contents::Ideal => 0,
            }
        };
        let warm_up = Kind::ALL.into_iter().map(lines).max().unwrap_or(0).div_ceil(rays);
        Self { stratum, rays, warm_up, seed }
    }

    /// Share of the windows that are measured.
    pub fn rate(&self) -> f64 {
        2.0 / self.stratum as f64
    }

    pub(super) fn measures(&self, window: usize) -> bool {
        let (stratum, place) = (window / self.stratum, window % self.stratum);
        let first = mix(self.seed ^ mix(2 * stratum as u64)) as usize % self.stratum;
        let step = mix(self.seed ^ mix(2 * stratum as u64 + 1)) as usize % (self.stratum - 1);
        place == first || place == (first + 1 + step) % self.stratum
    }
}

/// SplitMix64's output function (Steele, Lea and Flood 2014).
fn mix(seed: u64) -> u64 {
    let x = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// What is going on between two marks.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Segment {
    /// Nothing, or warm-up.
    Unmeasured,
    /// A window of that stratum, and lines that it touches for the first time.
    Window(usize, f64),
    /// A frame's end, and lines that it touches for the first time. All ends are measured.
    FrameEnd(f64),
}

/// The sample of a stream.
pub(super) struct Sample<'a, I> {
    items: I,
    machine: &'a MachineSpec,
    plan: Plan,
    recency: Recency,
    /// Items to be given, what they begin, and lines that the L2 is to hold then.
    ahead: VecDeque<(Item, Segment, Vec<Touch>)>,
    /// Windows told so far.
    windows: usize,
    fed: Totals,
    /// What the item that was given last begins; what goes on since the last mark, and the figures then.
    given: Option<Segment>,
    open: Segment,
    opened: BTreeMap<String, f64>,
    /// Operations of each kind of units then.
    operations: [u64; Kind::ALL.len()],
    warm: Vec<Touch>,
    skipped: bool,
    /// What was found.
    pub population: Population,
    pub measured: Vec<Window>,
    ends: BTreeMap<String, f64>,
    /// Rays that were replayed.
    pub replayed: u64,
    /// Rays of the stream, skipped ones not counted.
    rays: u64,
}

impl<'a, I> Sample<'a, I> {
    pub fn new(machine: &'a MachineSpec, header: &Header, plan: Plan, items: I) -> Self {
        Self {
            items,
            machine,
            plan,
            recency: Recency::new(header, machine),
            ahead: VecDeque::new(),
            windows: 0,
            fed: Totals::default(),
            given: None,
            open: Segment::Unmeasured,
            opened: BTreeMap::new(),
            operations: [0; Kind::ALL.len()],
            warm: Vec::new(),
            skipped: false,
            population: Population::default(),
            measured: Vec::new(),
            ends: BTreeMap::new(),
            replayed: 0,
            rays: 0,
        }
    }

    /// Plans the window of some rays of a chunk.
    fn window(&mut self, chunk: &Chunk, rays: Range<usize>) {
        let number = self.windows;
        self.windows += 1;
        let stratum = number / self.plan.stratum;
        let measured = self.plan.measures(number);
        let replayed = (number..=number + self.plan.warm_up).any(|window| self.plan.measures(window));
        let warm = if replayed && self.skipped { self.recency.since_replayed() } else { Vec::new() };
        self.skipped = !replayed;
        let known = self.recency.window(rays.clone().map(|index| chunk.ray(index)));
        self.population.strata.resize(stratum + 1, 0);
        self.population.strata[stratum] += 1;
        self.population.known.iter_mut().zip(known).for_each(|(sum, known)| *sum += known);
        self.rays += rays.clone().filter(|&index| chunk.head(index).decision != Decision::Skip).count() as u64;
        if !replayed {
            return;
        }
        let mut window = Chunk::default();
        for ray in rays.map(|index| chunk.ray(index)) {
            self.fed.count(&ray);
            window.push(ray.head, ray.packed_path(), ray.packed_policy());
        }
        self.replayed += window.len() as u64;
        self.recency.replays();
        let segment = if measured { Segment::Window(stratum, known[KNOWN - 1]) } else { Segment::Unmeasured };
        self.ahead.push_back((Item::Rays(Arc::new(window)), segment, warm));
    }

    /// The stream's statistics, as the sample lets them be estimated; `last` is what the engine counted in the end.
    pub fn estimate(&self, last: &MachineStats) -> MachineStats {
        let mut totals = estimate::estimate(&self.population, &self.measured);
        for (name, end) in &self.ends {
            totals.entry(name.clone()).or_default().total += end;
        }
        let figures: BTreeMap<String, f64> = totals.iter().map(|(name, total)| (name.clone(), total.total)).collect();
        let mut stats = figures::with(last, figures.iter().filter(|(name, _)| !name.starts_with('=')));
        stats.rays = self.rays;
        let share = |name: &str| {
            let total = totals.get(name)?;
            Some(if total.total > 0.0 { total.half_width? / total.total } else { 0.0 })
        };
        stats.accuracy = match (share("cycles"), share(DRAM_BYTES)) {
            (Some(cycles), Some(dram_bytes)) => Accuracy::Estimated { cycles, dram_bytes },
            _ => Accuracy::Unknown,
        };
        let half_widths = totals.iter().filter(|(name, _)| !name.starts_with('='));
        stats.half_widths = half_widths.filter_map(|(name, total)| Some((name.clone(), total.half_width?))).collect();
        stats
    }
}

/// A sum that no field of the statistics holds.
const DRAM_BYTES: &str = "=bytes.dram";

impl<E, I: Iterator<Item = Result<Item, E>>> Feed<E> for Sample<'_, I> {
    fn next(&mut self) -> Result<Option<Item>, RunError<E>> {
        loop {
            if let Some((item, segment, warm)) = self.ahead.pop_front() {
                self.given = Some(segment);
                self.warm.extend(warm);
                return Ok(Some(item));
            }
            match self.items.next().transpose().map_err(RunError::Source)? {
                None => {
                    self.given = Some(Segment::Unmeasured);
                    return Ok(None);
                }
                Some(Item::Frame(info)) => {
                    self.recency.begin_frame(&info);
                    self.ahead.push_back((Item::Frame(info), Segment::Unmeasured, Vec::new()));
                }
                Some(Item::Rays(chunk)) => pieces(&chunk, self.plan.rays, |rays| self.window(&chunk, rays)),
                Some(Item::End { policy, .. }) => {
                    let known = self.recency.frame_end(&policy);
                    self.population.known.iter_mut().zip(known).for_each(|(sum, known)| *sum += known);
                    let mut totals = std::mem::take(&mut self.fed);
                    totals.count_policy(Step::unpack_all(&policy));
                    self.ahead.push_back((
                        Item::End { policy, totals },
                        Segment::FrameEnd(known[KNOWN - 1]),
                        Vec::new(),
                    ));
                }
            }
        }
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError<E>> {
        super::check::frame(counts, &self.machine.shadow_cache)
    }

    fn marks(&self) -> bool {
        self.given.is_some()
    }

    fn taken(&mut self, tally: &Tally) -> Vec<Touch> {
        let stats = tally.stats(self.machine);
        let mut now = figures::of(&stats);
        now.insert(DRAM_BYTES.into(), stats.moved("dram").0 as f64);
        let passed = figures::difference(&now, &self.opened);
        let operations = tally.operations_by_kind();
        // What was done between two marks is not quite what the window's rays ask for: some were begun before, some end later.
        let known = |new_lines| {
            let done = |kind: usize| (operations[kind] - self.operations[kind]) as f64;
            std::array::from_fn(|at| if at < Kind::ALL.len() { done(at) } else { new_lines })
        };
        match self.open {
            Segment::Unmeasured => {}
            Segment::Window(stratum, new_lines) => {
                self.measured.push(Window { stratum, known: known(new_lines), measured: passed });
            }
            Segment::FrameEnd(new_lines) => {
                let known: [f64; KNOWN] = known(new_lines);
                self.population.known.iter_mut().zip(known).for_each(|(sum, known)| *sum -= known);
                passed.into_iter().for_each(|(name, value)| *self.ends.entry(name).or_default() += value);
            }
        }
        (self.opened, self.operations) = (now, operations);
        self.open = self.given.take().unwrap_or(Segment::Unmeasured);
        std::mem::take(&mut self.warm)
    }
}

/// Cuts a chunk at primary rays into pieces of `rays` rays or a little more.
fn pieces(chunk: &Chunk, rays: usize, mut give: impl FnMut(Range<usize>)) {
    let mut start = 0;
    for index in 1..chunk.len() {
        if index - start >= rays && chunk.head(index).kind == RayKind::Primary {
            give(start..index);
            start = index;
        }
    }
    if start < chunk.len() {
        give(start..chunk.len());
    }
}
