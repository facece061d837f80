//! Sampling: of each stratum of consecutive windows (runs of pixels of about the same number of rays) some are replayed and measured,
//! each behind a window of warm-up; the accesses of all others go through the caches' tags alone.

pub mod estimate;
pub mod figures;
mod plan;
mod warming;

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::Arc;

use self::estimate::{KNOWN, Population, Total, Window, with_operations};
use self::plan::PIECES;
pub use self::plan::Plan;
pub use self::warming::Warming;
use super::RunError;
use super::feed::Feed;
use super::tally::Tally;
use super::work::{Kind, stores_as_recorded};
use crate::machine::MachineSpec;
use crate::machine::source::FrameCounts;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::{Chunk, Decision, Header, Item, RayKind, Step, Totals};

/// A piece that was given and is not over.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Given {
    /// Its window, if that is measured.
    measured: Option<usize>,
    /// What is known of it; nothing until the next item is asked for.
    known: [f64; KNOWN],
}

/// What was given and has not gone through the warm caches yet: they are to be as they were before it.
enum Pending {
    Rays(Arc<Chunk>),
    End(Arc<Vec<u32>>),
}

/// What a sample found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// All windows, frames' ends left out.
    pub population: Population,
    /// Those that were measured.
    pub measured: Vec<Window>,
    /// Sums over frames' ends.
    ends: BTreeMap<String, f64>,
    /// Rays of the stream, skipped ones not counted.
    rays: u64,
}

/// The sample of a stream.
pub(super) struct Sample<'a, I> {
    items: I,
    machine: &'a MachineSpec,
    plan: Plan,
    warm: Warming,
    /// The chunk at hand, and where its next piece begins.
    chunk: Option<(Arc<Chunk>, usize)>,
    /// Pieces told so far, and whether each window of these and some more is measured.
    pieces: usize,
    measures: Vec<bool>,
    fed: Totals,
    pending: Option<Pending>,
    /// Pieces that are not over, in order.
    given: VecDeque<Given>,
    /// What is known of the frame's end that was given last.
    end: [f64; KNOWN],
    /// The window measured last.
    last: Option<usize>,
    /// How many pieces were over in this cycle, and whether the frame was.
    over: usize,
    frame_over: bool,
    /// The figures, and operations of each kind of units, at the last mark.
    opened: BTreeMap<String, f64>,
    operations: [u64; Kind::ALL.len()],
    /// Whether pieces were skipped since the last that was given, so that the engine's caches are out of date.
    skipped: bool,
    /// Whether the machine performs the operations that the stream asks for, no more and no fewer.
    as_recorded: bool,
    pub findings: Findings,
}

impl<'a, I> Sample<'a, I> {
    pub fn new(machine: &'a MachineSpec, header: &Header, plan: Plan, items: I) -> Self {
        Self {
            items,
            machine,
            plan,
            warm: Warming::new(header, machine),
            chunk: None,
            pieces: 0,
            measures: Vec::new(),
            fed: Totals::default(),
            pending: None,
            given: VecDeque::new(),
            end: [0.0; KNOWN],
            last: None,
            over: 0,
            frame_over: false,
            opened: BTreeMap::new(),
            operations: [0; Kind::ALL.len()],
            skipped: false,
            as_recorded: stores_as_recorded(machine),
            findings: Findings::default(),
        }
    }

    /// The next piece's rays, if the chunk at hand has more.
    fn piece(&mut self) -> Option<(Arc<Chunk>, Range<usize>)> {
        let (chunk, start) = self.chunk.take().filter(|(chunk, start)| *start < chunk.len())?;
        let primaries = (start..chunk.len()).filter(|&index| chunk.head(index).kind == RayKind::Primary);
        let end = primaries.into_iter().nth(self.plan.pixels).unwrap_or(chunk.len());
        self.chunk = Some((Arc::clone(&chunk), end));
        Some((chunk, start..end))
    }

    /// What was given goes through the warm caches.
    fn settle(&mut self) {
        let Some(pending) = self.pending.take() else { return };
        let (known, place) = match pending {
            Pending::Rays(chunk) => {
                (self.warm.piece(chunk.rays()), self.given.back_mut().map(|given| &mut given.known))
            }
            Pending::End(steps) => (self.warm.frame_end(&steps), Some(&mut self.end)),
        };
        self.findings.population.add(&known);
        if let Some(place) = place {
            *place = known;
        }
    }

    /// Whether the engine's caches are out of date, and no piece that is measured would see them change.
    fn holds(&self) -> bool {
        let fresh = usize::from(!matches!(self.pending, Some(Pending::End(_))));
        self.skipped && self.given.iter().rev().skip(fresh).all(|given| given.measured.is_none())
    }

    fn measures(&mut self, window: usize) -> bool {
        while self.measures.len() <= window {
            self.measures.extend(self.plan.measures(self.measures.len() / self.plan.stratum));
        }
        self.measures[window]
    }

    /// Takes a piece: the item, if it is replayed.
    fn take(&mut self, chunk: &Chunk, rays: Range<usize>) -> Option<Item> {
        let (window, place) = (self.pieces / PIECES, self.pieces % PIECES);
        self.pieces += 1;
        let stratum = window / self.plan.stratum;
        self.findings.population.strata.resize(stratum + 1, 0);
        self.findings.population.strata[stratum] += u64::from(place == 0);
        let traced = |&index: &usize| chunk.head(index).decision != Decision::Skip;
        self.findings.rays += rays.clone().filter(traced).count() as u64;
        let measured = self.measures(window);
        // A piece before fills what is in flight, one behind keeps it full.
        let beside =
            place == 0 && window > 0 && self.measures(window - 1) || place == PIECES - 1 && self.measures(window + 1);
        if !measured && !beside {
            self.skipped = true;
            let known = self.warm.piece(rays.map(|index| chunk.ray(index)));
            self.findings.population.add(&known);
            return None;
        }
        let mut piece = Chunk::default();
        for ray in rays.map(|index| chunk.ray(index)) {
            self.fed.count(&ray);
            piece.push(ray.head, ray.packed_path(), ray.packed_policy());
        }
        let piece = Arc::new(piece);
        self.pending = Some(Pending::Rays(Arc::clone(&piece)));
        self.given.push_back(Given { measured: measured.then_some(window), known: [0.0; KNOWN] });
        Some(Item::Rays(piece))
    }
}

impl<E, I: Iterator<Item = Result<Item, E>>> Feed<E> for Sample<'_, I> {
    fn next(&mut self) -> Result<Option<Item>, RunError<E>> {
        self.settle();
        loop {
            if let Some((chunk, rays)) = self.piece() {
                if let Some(item) = self.take(&chunk, rays) {
                    return Ok(Some(item));
                }
                continue;
            }
            match self.items.next().transpose().map_err(RunError::Source)? {
                None => return Ok(None),
                Some(Item::Frame(info)) => {
                    self.warm.begin_frame(&info);
                    return Ok(Some(Item::Frame(info)));
                }
                Some(Item::Rays(chunk)) => self.chunk = Some((chunk, 0)),
                Some(Item::End { policy, .. }) => {
                    let mut totals = std::mem::take(&mut self.fed);
                    totals.count_policy(Step::unpack_all(&policy));
                    self.pending = Some(Pending::End(Arc::clone(&policy)));
                    return Ok(Some(Item::End { policy, totals }));
                }
            }
        }
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError<E>> {
        self.frame_over = true;
        super::check::frame(counts, &self.machine.shadow_cache)
    }

    fn chunks_over(&mut self, chunks: usize) {
        self.over += chunks;
    }

    fn marks(&self) -> bool {
        self.over > 0 || self.frame_over || self.holds()
    }

    fn mark(&mut self, tally: &Tally) -> Option<&Warming> {
        let stats = tally.stats(self.machine);
        let mut now = figures::of(&stats);
        now.insert(DRAM_BYTES.into(), stats.moved("dram").0 as f64);
        now.insert(L2_BYTES.into(), moved_l2(&stats) as f64);
        let passed = figures::difference(&now, &self.opened);
        let operations = tally.operations_by_kind();
        // What was done between two marks is not quite what the window's rays ask for: some were begun before, some end later.
        let done: [u64; Kind::ALL.len()] = std::array::from_fn(|kind| operations[kind] - self.operations[kind]);
        let as_recorded = self.as_recorded;
        let known = |asked, done| if as_recorded { with_operations(asked, done) } else { asked };
        (self.opened, self.operations) = (now, operations);
        if std::mem::take(&mut self.frame_over) {
            if let Some(Pending::End(_)) = self.pending {
                self.settle();
            }
            self.findings.population.add(&known(self.end, done).map(|known| -known));
            passed.into_iter().for_each(|(name, value)| *self.findings.ends.entry(name).or_default() += value);
            return None;
        }
        // Of several pieces that are over in one cycle the first gets all that was counted.
        let mut counted = (done, passed);
        for Given { measured, known: asked } in self.given.drain(..std::mem::take(&mut self.over)) {
            let (done, passed) = std::mem::take(&mut counted);
            let Some(window) = measured else { continue };
            let piece = Window { stratum: window / self.plan.stratum, known: known(asked, done), measured: passed };
            match self.findings.measured.last_mut().filter(|_| self.last == Some(window)) {
                Some(begun) => begun.add(piece),
                None => self.findings.measured.push(piece),
            }
            self.last = Some(window);
        }
        if !self.holds() {
            return None;
        }
        self.skipped = false;
        Some(&self.warm)
    }
}

/// Sums that no field of the statistics holds.
const L2_BYTES: &str = "=bytes.l2";
const DRAM_BYTES: &str = "=bytes.dram";

/// Bytes between the L1s and all caches of the L2.
fn moved_l2(stats: &MachineStats) -> u64 {
    let levels = stats.bytes.iter().filter(|(level, _)| level.starts_with("l2"));
    levels.flat_map(|(_, classes)| classes.values()).map(|bytes| bytes.0).sum()
}

impl Findings {
    /// Adds what a later pass over the same stream measured.
    pub fn join(&mut self, other: Self) {
        let before = std::mem::take(&mut self.measured);
        *self = other;
        self.measured.extend(before);
    }

    /// The stream's statistics, as the sample lets them be estimated; `last` is what the engine counted in the end, `rate` the
    /// share of windows that were measured.
    pub fn estimate(&self, last: &MachineStats, rate: f64) -> MachineStats {
        let mut totals = estimate::estimate(&self.population, &self.measured);
        for (name, end) in &self.ends {
            totals.entry(name.clone()).or_default().total += end;
        }
        let named = || totals.iter().filter(|(name, _)| !name.starts_with('='));
        let figures: BTreeMap<String, f64> = named().map(|(name, total)| (name.clone(), total.total)).collect();
        let mut stats = figures::with(last, figures.iter());
        stats.rays = self.rays;
        let share = |name: &str| totals.get(name).and_then(Total::share);
        stats.accuracy = match (share("cycles"), share(L2_BYTES), share(DRAM_BYTES)) {
            (Some(cycles), Some(l2_bytes), Some(dram_bytes)) => {
                Accuracy::Estimated { cycles, l2_bytes, dram_bytes, rate }
            }
            _ => Accuracy::Unknown,
        };
        stats.half_widths = named().filter_map(|(name, total)| Some((name.clone(), total.half_width?))).collect();
        stats
    }
}
