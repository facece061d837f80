//! Failure maps of the fidelity levels: synthetic streams, swept over the properties on which the levels' errors
//! depend. They show each level's error against `Event`.

use std::sync::Arc;

use rayon::prelude::*;

use super::progress::{self, Progress};
use crate::machine::MachineSpec;
use crate::quantity::{LightId, NodeId, PixelId, PrimitiveId, Resolution, TriangleSlot};
use crate::ranged::{Size, Within};
use crate::replay::{Fidelity, Replay, ReuseOf, RunError, Sampled, Share};
use crate::report::ladder_map::{Axis, Covered, Figure, LadderMap, Point, Row};
use crate::scene::builtin::shapes::hash;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::{
    Chunk, Decision, FrameInfo, Header, Item, Outcome, RayHead, RayKind, Step, Stop, Store, StoreEntries, Structure,
    Totals,
};

/// The most rays of a chunk of a stream.
const CHUNK: u64 = 4096;
/// Steps of a ray: first nodes, then triangles.
const NODES: u64 = 20;
const TRIANGLES: u64 = 3;
/// The factor by which the rays of a burst are longer.
const BURST: u64 = 10;
/// The share of windows that is sampled.
const RATE: f64 = 0.25;
/// The share of lines whose reuse is measured, and the hottest that are always among them.
const LINES: f64 = 0.05;
const HOT: usize = 256;

/// No axis has the name.
#[derive(Debug, thiserror::Error)]
#[error("no axis begins with `{name}`; known are {known}")]
pub(crate) struct UnknownAxis {
    name: String,
    known: String,
}

/// How many points are replayed, on streams of which length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// All points: some minutes.
    Full,
    /// Every other point, on streams an eighth as long: less than a minute.
    Quick,
}

impl Effort {
    /// Rays of a stream, unless the axis sweeps its length.
    fn rays(self) -> u64 {
        match self {
            Self::Full => 131_072,
            Self::Quick => 16_384,
        }
    }

    /// The number of samples, each with its own seed.
    fn seeds(self) -> u64 {
        match self {
            Self::Full => 5,
            Self::Quick => 2,
        }
    }

    /// Replays every `step`-th point.
    fn step(self) -> usize {
        match self {
            Self::Full => 1,
            Self::Quick => 2,
        }
    }
}

/// A stream and the machine that replays it.
#[derive(Clone, Debug)]
struct Case {
    /// Rays of the stream.
    rays: u64,
    /// Updates of mode words that each ray sends to the only shadow-cache unit.
    updates: u64,
    /// Zipf exponent of the lines' popularity; with 0 all are equally popular.
    skew: f64,
    /// Bytes of nodes; triangles have a quarter as many.
    footprint: u64,
    /// The probability that a step repeats the previous ray's step.
    coherence: f64,
    /// Number of longer rays, in the middle of the stream.
    burst: u64,
    machine: MachineSpec,
}

impl Case {
    /// The case with default values.
    fn new(effort: Effort) -> Self {
        Self {
            rays: effort.rays(),
            updates: 0,
            skew: 0.8,
            footprint: 512 << 10,
            coherence: 0.8,
            burst: 0,
            machine: MachineSpec::default(),
        }
    }
}

/// Draws numbers below a count by Zipf's law.
struct Popular {
    /// Cumulative weights, by rank.
    sums: Vec<f64>,
    /// The number of each rank.
    order: Vec<u32>,
}

impl Popular {
    fn new(count: u64, skew: f64) -> Self {
        let mut sum = 0.0;
        let weight = |place: u64| {
            sum += (place as f64).powf(-skew);
            sum
        };
        let sums = (1..=count).map(weight).collect();
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.sort_by(|&a, &b| hash(u64::from(a)).total_cmp(&hash(u64::from(b))));
        Self { sums, order }
    }

    fn draw(&self, dice: f64) -> u32 {
        let sought = dice * self.sums[self.sums.len() - 1];
        self.order[self.sums.partition_point(|&sum| sum <= sought).min(self.order.len() - 1)]
    }
}

impl Case {
    fn lines(&self) -> u64 {
        self.footprint / Structure::Bvh2.node_bytes()
    }

    fn header(&self) -> Header {
        let lines = self.lines() as u32;
        let words =
            StoreEntries { mode_words: lines, word_owners: lines, words_per_primitive: 1, ..StoreEntries::default() };
        Header {
            scene: "made to order".into(),
            frames: vec![0],
            warmup: Vec::new(),
            resolution: Resolution { width: 128, height: 128 },
            policy: "none".into(),
            structure: Structure::Bvh2,
            lights: 0,
            static_primitives: lines,
            primitives: lines,
            static_nodes: lines,
            static_slots: lines.div_ceil(3),
            static_list_entries: 0,
            stores: if self.updates > 0 { words } else { StoreEntries::default() },
            unjudged_updates: false,
            input_hash: 0,
            records: Vec::new().into(),
        }
    }

    /// One frame of primary rays.
    fn stream(&self) -> Vec<Item> {
        let nodes = Popular::new(self.lines(), self.skew);
        let slots = Popular::new(self.lines().div_ceil(3), self.skew);
        let mut dice = 0;
        let mut throw = move || {
            dice += 1;
            hash(dice)
        };
        let info = FrameInfo { number: 0, dynamic_nodes: 0, dynamic_slots: 0, dynamic_list_entries: 0 };
        let (mut items, mut totals, mut chunk) = (vec![Item::Frame(info)], Totals::default(), Chunk::default());
        let mut path: Vec<u32> = Vec::new();
        for ray in 0..self.rays {
            let begin = self.rays.saturating_sub(self.burst) / 2;
            let times = if (begin..begin + self.burst).contains(&ray) { BURST } else { 1 };
            let before = std::mem::take(&mut path);
            for step in 0..times * (NODES + TRIANGLES) {
                let kept = before.get(step as usize).filter(|_| throw() < self.coherence);
                let mut drawn = || match step % (NODES + TRIANGLES) < NODES {
                    true => Step::Node(NodeId(nodes.draw(throw()))),
                    false => Step::Triangle { slot: TriangleSlot(slots.draw(throw())), stop: Stop::Edges },
                };
                path.push(kept.copied().unwrap_or_else(|| drawn().pack()));
            }
            let head = RayHead {
                kind: RayKind::Primary,
                light: LightId(0),
                decision: Decision::Trace,
                outcome: Outcome::Hit(PrimitiveId(0)),
                pixel: PixelId(ray as u32),
                parent: 0,
            };
            let mut word = || (throw() * self.lines() as f64) as u32;
            let updates: Vec<u32> =
                (0..self.updates).map(|_| Step::Update { store: Store::ModeWord, index: word() }.pack()).collect();
            chunk.push(head, &path, &updates);
            totals.count(&chunk.ray(chunk.len() - 1));
            if (ray + 1) % CHUNK.min(self.rays) == 0 {
                items.push(Item::Rays(Arc::new(std::mem::take(&mut chunk))));
            }
        }
        items.push(Item::End { policy: Arc::new(Vec::new()), totals });
        items
    }
}

/// Converts a number that is within the limits.
fn within<const LEAST: u64, const MOST: u64>(value: u64) -> Within<LEAST, MOST> {
    Within::new(value).expect("the sweep stays within what is allowed")
}

fn bytes<const LEAST: u64, const MOST: u64>(value: u64) -> Size<LEAST, MOST> {
    Size::new(value).expect("the sweep stays within what is allowed")
}

/// A point of an axis: its value as text, and the case.
type Made = (String, Case);

/// The axes with their points; all other properties are those of the default case.
fn axes(effort: Effort) -> Vec<(&'static str, Vec<Made>)> {
    fn points<T: Copy + ToString>(effort: Effort, values: &[T], set: impl Fn(&mut Case, T)) -> Vec<Made> {
        let point = |&value: &T| {
            let mut case = Case::new(effort);
            set(&mut case, value);
            (value.to_string(), case)
        };
        values.iter().step_by(effort.step()).map(point).collect()
    }
    vec![
        // A short stream has few windows to sample, and ends before its caches are warm.
        ("stream, rays", points(effort, &[1024, 4096, 16_384], |case, rays| case.rays = rays)),
        // The unit takes one ray per cycle and starts one operation per update: with enough updates it is the
        // bottleneck.
        ("updates a ray, one unit", points(effort, &[0, 2, 8, 32], |case, updates| case.updates = updates)),
        (
            "pool beyond the units",
            points(effort, &[0, 4, 16, 64], |case, more: u64| {
                let units = case.machine.traversal.rays.get() * case.machine.traversal.count.get();
                case.machine.dispatcher.rays = within(units + more);
            }),
        ),
        ("skew", points(effort, &[0.0, 0.5, 0.8, 1.0, 1.2, 1.5], |case, skew| case.skew = skew)),
        (
            "footprint, KiB",
            points(effort, &[8, 32, 128, 512, 2048, 8192], |case, size: u64| case.footprint = size << 10),
        ),
        ("coherence", points(effort, &[0.0, 0.5, 0.8, 0.9, 0.95, 0.99], |case, it| case.coherence = it)),
        (
            "L1, KiB",
            points(effort, &[1, 2, 8, 32, 128], |case, size: u64| {
                case.machine.traversal.cache.bytes = bytes(size << 10);
                case.machine.intersection.cache.bytes = bytes(size << 10);
            }),
        ),
        (
            "rays a unit",
            points(effort, &[1, 4, 20, 64, 256], |case, rays: u64| {
                case.machine.traversal.rays = within(rays);
                case.machine.dispatcher.rays = within(4 * rays + 48);
            }),
        ),
        (
            "miss registers",
            points(effort, &[1, 2, 8, 32], |case, registers: u64| {
                case.machine.traversal.cache.mshrs = within(registers);
                case.machine.intersection.cache.mshrs = within(registers);
            }),
        ),
        ("burst, rays", points(effort, &[0, 256, 1024, 4096], |case, rays: u64| case.burst = rays)),
    ]
}

/// Runs the axes whose names begin with one of `only`; all if it is empty.
///
/// # Errors
/// No axis begins with one of the names.
pub(crate) fn run(effort: Effort, only: &[String]) -> Result<LadderMap, UnknownAxis> {
    let mut axes = axes(effort);
    let begins = |axis: &str, wanted: &String| axis.starts_with(wanted.as_str());
    if let Some(name) = only.iter().find(|wanted| !axes.iter().any(|(axis, _)| begins(axis, wanted))) {
        let known = axes.iter().map(|(axis, _)| *axis).collect::<Vec<_>>().join("; ");
        return Err(UnknownAxis { name: name.clone(), known });
    }
    axes.retain(|(axis, _)| only.is_empty() || only.iter().any(|wanted| begins(axis, wanted)));
    let bar = progress::bar("ladder", axes.iter().map(|(_, points)| points.len()).sum(), "points");
    let axis = |(name, points): &(&str, Vec<Made>)| Axis {
        name: (*name).into(),
        points: points.par_iter().map(|(value, case)| point(value, case, effort.seeds(), &bar)).collect(),
    };
    let map = LadderMap { rows: rows(), axes: axes.iter().map(axis).collect() };
    drop(bar);
    Ok(map)
}

/// Names of the compared rows, in the order of [`point`].
fn rows() -> Vec<String> {
    [
        "Bound".into(),
        "Profile".into(),
        format!("Sampled, {RATE}"),
        "distances".into(),
        format!("{} % + {HOT} hot", LINES * 100.0),
        format!("{} % of lines", LINES * 100.0),
    ]
    .into()
}

fn point(value: &str, case: &Case, seeds: u64, bar: &Progress) -> Point {
    let (header, items) = (case.header(), case.stream());
    let replay = Replay::new(&case.machine, &header).unwrap_or_else(|error| panic!("a machine made to order: {error}"));
    let on = |fidelity: Fidelity| {
        let stats = replay.fidelity(fidelity).run(&items);
        stats.unwrap_or_else(|error| panic!("{fidelity} cannot replay what was made to order: {error}"))
    };
    let share = |share| Share::new(share).expect("a share");
    let event = on(Fidelity::Event);
    let exact =
        |stats: &MachineStats| Row { errors: Figure::ALL.map(|figure| figure.error(stats, &event)), covered: None };
    let sampled = || {
        let (mut worst, mut covered) = ([None; Figure::ALL.len()], Covered::default());
        for seed in 0..seeds {
            let engine = Sampled::Event;
            let fidelity = Fidelity::Sampled { engine, rate: share(RATE), seed, target_error: None };
            let stats = match replay.fidelity(fidelity).run(&items) {
                // The sample of a short stream may have no window: then the level gives no result.
                Err(RunError::Sample { .. }) => continue,
                stats => {
                    stats.unwrap_or_else(|error| panic!("{fidelity} cannot replay what was made to order: {error}"))
                }
            };
            for (worst, figure) in worst.iter_mut().zip(Figure::ALL) {
                let error = figure.error(&stats, &event);
                if error.map(f64::abs) > worst.map(f64::abs) {
                    *worst = error;
                }
            }
            if let Accuracy::Estimated { cycles, .. } = stats.accuracy {
                covered.told += 1;
                covered.held += u32::from((event.cycles.0 as f64 / stats.cycles.0 as f64 - 1.0).abs() <= cycles);
            }
        }
        Row { errors: worst, covered: Some(covered) }
    };
    let reuse = |of| {
        let found = replay.reuse(of, &items);
        let (_, levels) = found.unwrap_or_else(|error| panic!("reuse of what was made to order: {error}"));
        let level = levels.iter().find(|level| level.name == "l1_traversal");
        let misses = level.and_then(|level| level.miss_ratio_in_sets());
        let errors = Figure::ALL.map(|figure| misses.and_then(|ratio| figure.error_of_ratio(ratio, &event)));
        Row { errors, covered: None }
    };
    let rows = vec![
        exact(&on(Fidelity::Bound)),
        exact(&on(Fidelity::Profile)),
        sampled(),
        reuse(ReuseOf::Everything),
        reuse(ReuseOf::Sample { rate: share(LINES), hot: HOT }),
        reuse(ReuseOf::Sample { rate: share(LINES), hot: 0 }),
    ];
    bar.inc(1);
    Point { value: value.into(), cycles: event.cycles, rows }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn popular_numbers_are_drawn_by_their_law() {
        let even = Popular::new(4, 0.0);
        let drawn: std::collections::BTreeSet<u32> = (0..4).map(|at| even.draw(at as f64 / 4.0 + 0.1)).collect();
        assert_eq!(drawn.len(), 4);
        let steep = Popular::new(1000, 2.0);
        // The first rank has 1 / (pi^2 / 6) of the weight.
        assert_eq!(steep.draw(0.0), steep.draw(0.6));
        assert_ne!(steep.draw(0.0), steep.draw(0.62));
    }

    #[test]
    fn a_point_compares_every_row() {
        let case = Case { footprint: 8 << 10, ..Case::new(Effort::Quick) };
        let point = point("8", &case, 2, &Progress::hidden());
        assert_eq!(point.rows.len(), rows().len());
        // All lines fit the L1s and the L2: only first touches miss.
        let [bound, profile, ..] = point.rows.as_slice() else { panic!("rows") };
        assert!(bound.errors[Figure::Cycles as usize].is_some_and(|error| error < 0.0));
        assert!(profile.errors[Figure::DramBytes as usize].is_some_and(|error| error.abs() < 1e-12));
    }
}
