//! Replays one job by an engine of its own: a window with lead-in and tail, or an end of frame.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use super::covariates::{Capacity, Covariates, OPERATIONS};
use super::estimate::{Part, Window};
use super::figures::{Figure, Figures, Levels, MemoryLevel, difference};
use super::windows::{Job, JobWork, WindowWork};
use crate::engine::RunError;
use crate::engine::check;
use crate::engine::contract::Engine;
use crate::engine::feed::Feed;
use crate::engine::source::{FrameCounts, StoreWork};
use crate::engine::tally::{BankTally, PerClass, Tally, UnitTally};
use crate::engine::warm::WarmCaches;
use crate::engine::work::stores_as_recorded;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::stats::{CacheCounts, LatencyCounts, TrafficClass};
use crate::stream::{Item, Step, Totals};

/// Latencies by kind of rays, as in [`MachineStats`].
pub(super) type Latencies = BTreeMap<String, LatencyCounts>;

/// The result of a job.
#[derive(Clone, Debug)]
pub(crate) enum Found {
    /// A window's figures, and the latencies of all rays of the replay.
    Window(Box<Window>, Latencies),
    /// Figures of an end of frame.
    End(Figures),
}

/// Replays `job` with `engine`, which is new.
pub(super) fn replay(engine: &mut dyn Engine, machine: &MachineSpec, job: &Job) -> Result<Found, RunError> {
    let Job { info, warm, work, .. } = job;
    let mut feed = JobFeed::new(machine, warm);
    feed.items.push_back(Item::Frame(*info));
    match work {
        JobWork::End(policy) => {
            let mut totals = Totals::default();
            totals.count_policy(Step::unpack_all(policy));
            feed.items.push_back(Item::End { policy: Arc::clone(policy), totals });
            finished(engine, machine, &mut feed)?;
            let end = feed.marks.pop().map(|mark| mark.figures);
            Ok(Found::End(end.unwrap_or_default()))
        }
        JobWork::Window(work) => {
            let WindowWork { hits, before, own, behind, .. } = work.as_ref();
            let mut totals = Totals::default();
            let capacity = Capacity::new(machine);
            feed.bounds = [before.rays.len(), before.rays.len() + own.rays.len()];
            let mut sum = Covariates::default();
            for part in [before, own, behind] {
                sum += part.covariates;
                part.rays.rays().for_each(|ray| totals.count(&ray));
                if !part.rays.is_empty() {
                    feed.items.push_back(Item::Rays(Arc::clone(&part.rays)));
                }
            }
            let (lines, own, group) = (own.covariates.dram, own.covariates.columns(&capacity), sum.columns(&capacity));
            feed.items.push_back(Item::End { policy: Arc::default(), totals });
            let tally = finished(engine, machine, &mut feed)?;
            let (all, latency) = (figures_of(&tally, machine), tally.stats(machine).latency);
            let after = |rays: usize| feed.marks.iter().find(|mark| mark.over >= rays).cloned().unwrap_or_default();
            let [opened, closed] = feed.bounds.map(after);
            // The work between two marks differs slightly from the requests of the window's rays: some were begun
            // before, some end later.
            let done = std::array::from_fn(|kind| closed.operations[kind] - opened.operations[kind]);
            let inside = Part {
                covariates: if stores_as_recorded(machine) { capacity.with_operations(own, done) } else { own },
                figures: difference(&closed.figures, &opened.figures),
            };
            let (all_missed, own_missed) = (closed.missed.since(&opened.missed), Missed::attributed(&tally));
            let asked = Part {
                covariates: own,
                figures: asked_for(&inside.figures, (all_missed, own_missed), &lines, machine),
            };
            let spans = [inside, asked, Part { covariates: group, figures: all }];
            let window = Window { hits: hits.clone(), operations: own[OPERATIONS], spans };
            Ok(Found::Window(Box::new(window), latency))
        }
    }
}

/// Replays all items; checks the invariants of a whole run and returns the counts.
fn finished(engine: &mut dyn Engine, machine: &MachineSpec, feed: &mut JobFeed<'_>) -> Result<Tally, RunError> {
    let cycles = engine.run(feed)?;
    let tally = Tally { stores: feed.stores, ..engine.tally(cycles) };
    check::run(&tally, machine).map_err(RunError::Invariant)?;
    Ok(tally)
}

/// All figures; bytes that were not moved are 0.
fn figures_of(tally: &Tally, machine: &MachineSpec) -> Figures {
    let mut figures = Levels::new(machine).figures(&tally.stats(machine));
    // Tags may move classes that no window moves.
    for class in TrafficClass::ALL {
        let l2 = (!class.goes_past_caches()).then(|| MemoryLevel::L2(machine.l2.home(class)));
        for level in l2.into_iter().chain([MemoryLevel::Dram]) {
            figures.entry(Figure::Bytes(level, class)).or_insert(0.0);
        }
    }
    figures
}

/// Bytes between L1s and L2, and between L2 and DRAM, for the window's own rays. Lines that these missed replace the
/// lines missed between the marks. The counts between the marks stay for writes and for reads that bypass an L1; with a
/// register, also for misses on store entries, since its write-outs belong to no ray. The host's own `lines` are known.
fn asked_for(
    inside: &Figures,
    (missed, own): (Missed, Missed),
    lines: &PerClass<u64>,
    machine: &MachineSpec,
) -> Figures {
    const MISSES: usize = CacheCounts::place("misses");
    let line = machine.line_bytes.get() as f64;
    let (mut figures, mut l2_bytes, mut dram_bytes) = (Figures::new(), 0.0, 0.0);
    for class in TrafficClass::ALL {
        if class.is_of_host() {
            let bytes = lines[class as usize] as f64 * line;
            figures.insert(Figure::Bytes(MemoryLevel::Dram, class), bytes);
            dram_bytes += bytes;
            continue;
        }
        let of_scene = matches!(class, TrafficClass::Node | TrafficClass::List | TrafficClass::Triangle);
        let is_of_rays = of_scene || machine.shadow_cache.register.get() == 0;
        let more = |own: &PerClass<u64>, missed: &PerClass<u64>| {
            if is_of_rays { own[class as usize] as f64 - missed[class as usize] as f64 } else { 0.0 }
        };
        let (more_of_l2, more_of_dram) = (more(&own.l1s, &missed.l1s), more(&own.l2, &missed.l2));
        let home = MemoryLevel::L2(machine.l2.home(class));
        let mut own = |figure: Figure, more: f64| {
            let value = inside.get(&figure).copied().unwrap_or(0.0) + more;
            figures.insert(figure, value);
            value
        };
        l2_bytes += own(Figure::Bytes(home, class), more_of_l2 * line);
        dram_bytes += own(Figure::Bytes(MemoryLevel::Dram, class), more_of_dram * line);
        // The counts of a cache exist all together or not at all.
        let misses = Figure::Cache(home, class, MISSES);
        if inside.contains_key(&misses) {
            own(misses, more_of_dram);
        }
    }
    figures.extend([(Figure::L2Bytes, l2_bytes), (Figure::DramBytes, dram_bytes)]);
    figures
}

/// Missed lines, by class.
#[derive(Clone, Copy, Debug, Default)]
struct Missed {
    l1s: PerClass<u64>,
    /// Read misses only.
    l2: PerClass<u64>,
}

impl Missed {
    fn of(tally: &Tally, l1: fn(&UnitTally, usize) -> u64, l2: fn(&BankTally, usize) -> u64) -> Self {
        let (units, banks) = (|| tally.units.iter().flatten(), || tally.banks.iter());
        Self {
            l1s: std::array::from_fn(|class| units().map(|unit| l1(unit, class)).sum()),
            l2: std::array::from_fn(|class| banks().map(|bank| l2(bank, class)).sum()),
        }
    }

    fn all(tally: &Tally) -> Self {
        Self::of(tally, |unit, class| unit.cache[class].misses, |bank, class| bank.served.missed[class])
    }

    fn attributed(tally: &Tally) -> Self {
        Self::of(tally, |unit, class| unit.attributed[class], |bank, class| bank.served.attributed[class])
    }

    fn since(&self, before: &Self) -> Self {
        let less =
            |now: &PerClass<u64>, before: &PerClass<u64>| std::array::from_fn(|class| now[class] - before[class]);
        Self { l1s: less(&self.l1s, &before.l1s), l2: less(&self.l2, &before.l2) }
    }
}

/// A snapshot of the counts.
#[derive(Clone, Debug, Default)]
struct Mark {
    /// Number of rays done.
    over: usize,
    figures: Figures,
    operations: [u64; Kind::ALL.len()],
    missed: Missed,
}

/// The items of a job. The first mark is when as many rays are done as the lead-in has; the second, when as many more
/// are done as the window has. Any rays count, so that slow ones delay no mark.
struct JobFeed<'a> {
    items: VecDeque<Item>,
    machine: &'a MachineSpec,
    warm: &'a WarmCaches,
    /// Whether the engine's caches were loaded with `warm`.
    loaded: bool,
    bounds: [usize; 2],
    over: usize,
    frame_over: bool,
    /// Store operations performed otherwise than recorded.
    stores: StoreWork,
    marks: Vec<Mark>,
}

impl<'a> JobFeed<'a> {
    fn new(machine: &'a MachineSpec, warm: &'a WarmCaches) -> Self {
        let items = VecDeque::new();
        // The first mark of a window without lead-in: nothing was counted.
        let marks = vec![Mark::default()];
        Self {
            items,
            machine,
            warm,
            loaded: false,
            bounds: [0; 2],
            over: 0,
            frame_over: false,
            stores: StoreWork::default(),
            marks,
        }
    }
}

impl Feed for JobFeed<'_> {
    fn next(&mut self) -> Result<Option<Item>, RunError> {
        Ok(self.items.pop_front())
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError> {
        self.frame_over = true;
        self.stores += counts.stores;
        check::frame(counts, &self.machine.shadow_cache)
    }

    fn rays_over(&mut self, rays: usize) {
        self.over += rays;
    }

    fn marks(&self) -> bool {
        let before = self.marks.last().map_or(0, |mark| mark.over);
        let passes = |bound: usize| (before + 1..=self.over).contains(&bound);
        !self.loaded || self.bounds.into_iter().any(passes) || self.frame_over
    }

    fn mark(&mut self, tally: &Tally) -> Option<&WarmCaches> {
        if !std::mem::replace(&mut self.loaded, true) {
            return Some(self.warm);
        }
        self.frame_over = false;
        let (over, operations) = (self.over, tally.operations_by_kind());
        let (figures, missed) = (figures_of(tally, self.machine), Missed::all(tally));
        self.marks.push(Mark { over, figures, operations, missed });
        None
    }
}
