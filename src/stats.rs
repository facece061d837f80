//! What a timing run measured, as plain data: the timing side fills it, reports read it, neither knows the other.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::quantity::{Bytes, Cycle};

/// What memory traffic is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrafficClass {
    /// Nodes of the acceleration structure.
    Node,
    /// Primitive lists of the kd-tree.
    List,
    /// Triangle records.
    Triangle,
    /// Mode words.
    ModeWord,
    /// Counters of rendered pixels.
    PixelCounter,
    /// Ids of occluders.
    OccluderId,
    /// Rays.
    Ray,
}

impl TrafficClass {
    /// All classes.
    pub const ALL: [Self; 7] =
        [Self::Node, Self::List, Self::Triangle, Self::ModeWord, Self::PixelCounter, Self::OccluderId, Self::Ray];

    /// The class's name in reports, as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::List => "list",
            Self::Triangle => "triangle",
            Self::ModeWord => "mode_word",
            Self::PixelCounter => "pixel_counter",
            Self::OccluderId => "occluder_id",
            Self::Ray => "ray",
        }
    }
}

/// The one cause that each cycle of a unit has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The unit began an operation in this cycle.
    Busy,
    /// It had nothing to do: no ray in it, and none in front of it that it could take.
    Starved,
    /// It had rays, all inside its pipeline.
    Pipeline,
    /// It had rays, and the first that waits does so for data of its cache.
    Memory,
    /// It had a result that its neighbour could not take.
    Blocked,
    /// It took as many rays as it can in a cycle, none of them began an operation, and others waited in front of it.
    Intake,
}

impl Cause {
    /// All causes, in the order of plots.
    pub const ALL: [Self; 6] = [Self::Busy, Self::Pipeline, Self::Memory, Self::Blocked, Self::Intake, Self::Starved];

    /// The cause's name in reports, as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Busy => "busy",
            Self::Starved => "starved",
            Self::Pipeline => "pipeline",
            Self::Memory => "memory",
            Self::Blocked => "blocked",
            Self::Intake => "intake",
        }
    }
}

/// Accesses to a cache, of one class of traffic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CacheCounts {
    /// Accesses: hits, half misses, misses and passed writes together.
    pub accesses: u64,
    /// The line was there.
    pub hits: u64,
    /// The line was already on its way.
    pub half_misses: u64,
    /// The line was fetched.
    pub misses: u64,
    /// Writes whose line was not there, and that allocate none: they went down.
    #[serde(default)]
    pub passed_writes: u64,
    /// Accesses that had to wait for the next cycle, since their bank had made another: each once a cycle.
    #[serde(default)]
    pub bank_conflicts: u64,
    /// Dirty lines of the class that were written back.
    pub write_backs: u64,
}

impl CacheCounts {
    /// Hits over accesses; `None` without an access.
    pub fn hit_rate(&self) -> Option<f64> {
        (self.accesses > 0).then(|| self.hits as f64 / self.accesses as f64)
    }
}

/// Misses of a class in LRU caches of any size, from reuse distances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReuseCurve {
    /// Accesses.
    pub accesses: u64,
    /// Accesses that the sampled lines stand for; all, without a sample.
    pub sampled: f64,
    /// First touches of a line by a cache.
    pub first_touches: f64,
    /// Misses, first touches included, of caches without sets, for each of [`ReuseCurve::sizes`].
    pub misses: Vec<f64>,
    /// Misses of the cache as the machine has it, if lines fall into its sets at random.
    pub misses_in_sets: f64,
}

impl ReuseCurve {
    /// Sizes of caches in bytes: powers of two from 1 kB to 16 MB.
    pub fn sizes() -> impl Iterator<Item = u64> {
        (10..=24).map(|power| 1 << power)
    }
}

/// Reuse in the caches of a kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReuseLevel {
    /// Their name in reports.
    pub name: String,
    /// How many there are.
    pub caches: u64,
    /// Bytes of each in the machine.
    pub bytes: u64,
    /// Lines a set in the machine.
    pub ways: u64,
    /// By class.
    pub classes: BTreeMap<TrafficClass, ReuseCurve>,
}

impl ReuseLevel {
    /// Misses over accesses of the caches as the machine has them, if lines fall into their sets at random; `None` without an access.
    pub fn miss_ratio_in_sets(&self) -> Option<f64> {
        let sum = |of: fn(&ReuseCurve) -> f64| self.classes.values().map(of).sum::<f64>();
        let sampled = sum(|curve| curve.sampled);
        (sampled > 0.0).then(|| sum(|curve| curve.misses_in_sets) / sampled)
    }
}

/// A DRAM's column commands and what they met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DramCounts {
    /// Reads served.
    pub reads: u64,
    /// Writes served.
    pub writes: u64,
    /// The row was open.
    pub row_hits: u64,
    /// No row was open.
    pub row_misses: u64,
    /// Another row was open.
    pub row_conflicts: u64,
    /// Refreshes.
    pub refreshes: u64,
}

/// What went through queues between parts of a kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct QueueCounts {
    /// Entries that were put in.
    pub entries: u64,
    /// Cycles that they stood there, summed: over the run's cycles the mean number that stood there (Little 1961).
    pub waited: u64,
}

/// How long traced rays of a kind took, policy steps included, from being handed over to being done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LatencyCounts {
    /// Rays.
    pub rays: u64,
    /// Their cycles, summed.
    pub cycles: u64,
    /// What they would have taken at least, alone and with every line at hand, policy steps left out.
    pub unloaded: u64,
    /// The longest.
    pub most: u64,
}

/// From the least to the most, both included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Range<T> {
    /// It cannot be less.
    pub least: T,
    /// It cannot be more.
    pub most: T,
}

/// What no machine of the spec can leave on the stream, whatever it does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bounds {
    /// Cycles: the least is the largest of what its parts must do over what they can do a cycle, the most is everything missed
    /// and one thing after another.
    pub cycles: Range<Cycle>,
    /// Bytes between the L1s and the L2: the least is every line once a kind of units.
    pub l2_bytes: Range<Bytes>,
    /// Bytes between the L2 and the DRAM: the least is every line once.
    pub dram_bytes: Range<Bytes>,
}

/// What could not be beaten if the answers of all shadow rays were known for nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limit {
    /// Cycles.
    pub cycles: Cycle,
    /// Bytes of the DRAM.
    pub dram_bytes: Bytes,
}

/// How far a run's numbers may be from those of `Event` and `Cycle`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// They are those.
    #[default]
    Exact,
    /// The truth lies within an interval with a probability of 95 %; the shares are half its width over the estimate.
    Estimated {
        /// Of the cycles.
        cycles: f64,
        /// Of the bytes between the L1s and the L2.
        l2_bytes: f64,
        /// Of the bytes of the DRAM.
        dram_bytes: f64,
        /// Share of the windows that were measured.
        rate: f64,
    },
    /// Nothing is known: a sample of so few windows tells nothing about itself.
    Few {
        /// Windows that were measured.
        windows: usize,
        /// From how many on it would.
        telling: usize,
    },
    /// Nothing is known but that the truth lies within [`MachineStats::bounds`].
    Bounded,
    /// Nothing is known.
    Unknown,
}

impl Accuracy {
    /// Half the widths of the intervals of cycles, L2 and DRAM bytes over the figures, where they are known.
    pub fn shares(&self) -> Option<[f64; 3]> {
        match *self {
            Self::Exact => Some([0.0; 3]),
            Self::Estimated { cycles, l2_bytes, dram_bytes, .. } => Some([cycles, l2_bytes, dram_bytes]),
            Self::Few { .. } | Self::Bounded | Self::Unknown => None,
        }
    }

    /// Half the width of the interval of a figure's ratio to what it was before, if samples tell both; `figure` is its place in [`Accuracy::shares`]. At worst their errors add up,
    /// since the samples are of different rays.
    pub fn of_ratio(&self, before: &Self, figure: usize, ratio: f64) -> Option<f64> {
        let share = self.shares()?[figure] + before.shares()?[figure];
        (*self != Self::Exact || *before != Self::Exact).then_some(ratio * share)
    }

    /// The largest of the shares, if they are known.
    pub fn widest(&self) -> Option<f64> {
        self.shares().map(|shares| shares.into_iter().fold(0.0, f64::max))
    }

    /// Whether all shares that are known are at most `target`, and nothing else is known to be off.
    pub fn is_within(&self, target: f64) -> bool {
        self.widest().is_some_and(|widest| widest <= target)
    }
}

/// What a stream needs of a machine's model, as a pilot found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Needs {
    /// The error that was asked for.
    pub target: f64,
    /// Share of the pixels in the pilot; as many were held back.
    pub pilot_share: f64,
    /// What each part that can be left out is worth.
    pub parts: Vec<PartNeed>,
    /// The models that were tried, the cheapest first; the last is the one that was taken.
    pub models: Vec<ModelCheck>,
}

/// What a part of the machine is worth: the pilot's figures change by these shares without it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartNeed {
    /// The part.
    pub part: String,
    /// Cycles.
    pub cycles: Option<f64>,
    /// Bytes between L1s and L2.
    pub l2_bytes: Option<f64>,
    /// DRAM bytes.
    pub dram_bytes: Option<f64>,
    /// Whether it matters: rungs below a sample have no parts that do not.
    pub matters: bool,
}

/// How a model did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelCheck {
    /// The model.
    pub model: String,
    /// The largest error of its cycles and bytes on the pilot; of a sample, half its widest interval.
    pub error: Option<f64>,
    /// The same on what was held back.
    pub held_back: Option<f64>,
    /// Whether it will do.
    pub passes: bool,
}

/// What one machine measured on one stream.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineStats {
    /// Time from the first ray to the last write-back.
    pub cycles: Cycle,
    /// The machine's clock.
    pub clock_mhz: f64,
    /// Rays replayed, skipped ones not counted.
    pub rays: u64,
    /// Bytes moved a level (`l1_traversal`, ..., `l2`, `dram`) and class. A level's bytes are those moved between it
    /// and the level above (towards the units).
    pub bytes: BTreeMap<String, BTreeMap<TrafficClass, Bytes>>,
    /// Accesses a cache (all instances of a kind together) and class.
    pub caches: BTreeMap<String, BTreeMap<TrafficClass, CacheCounts>>,
    /// Cycles of every unit kind, summed over its instances, by cause.
    pub units: BTreeMap<String, BTreeMap<Cause, u64>>,
    /// Instances of every unit kind: the causes of a kind sum to `cycles` times this.
    pub unit_counts: BTreeMap<String, u64>,
    /// Queues between parts, by who takes from them; of rungs that have queues.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub queues: BTreeMap<String, QueueCounts>,
    /// Latencies by kind of rays; of rungs that know them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub latency: BTreeMap<String, LatencyCounts>,
    /// The DRAM's commands.
    pub dram: DramCounts,
    /// The DRAM's channels, part, page policy and address mapping, in words.
    pub dram_organization: String,
    /// Peak bandwidth of the DRAM in bytes a machine cycle; a flat one may have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dram_peak_bytes_per_cycle: Option<f64>,
    /// How far from the truth these numbers may be.
    #[serde(default)]
    pub accuracy: Accuracy,
    /// Half the widths of the 95 % intervals of estimated figures, by their path: `bytes.l2.node`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub half_widths: BTreeMap<String, f64>,
    /// What the stream needs; where somebody asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needs: Option<Needs>,
    /// What no machine can leave.
    #[serde(default)]
    pub bounds: Option<Bounds>,
    /// What culling cannot beat; where it was computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub oracle: Option<Limit>,
}

impl MachineStats {
    /// Bytes moved at a level, all classes together; none if there is no such level.
    pub fn moved(&self, level: &str) -> Bytes {
        self.bytes.get(level).into_iter().flat_map(|classes| classes.values()).copied().sum()
    }

    /// Hits over accesses, a cache and class of traffic, where there are any.
    pub fn hit_rates(&self) -> BTreeMap<String, BTreeMap<TrafficClass, f64>> {
        let of = |classes: &BTreeMap<TrafficClass, CacheCounts>| {
            classes.iter().filter_map(|(&class, counts)| Some((class, counts.hit_rate()?))).collect()
        };
        self.caches.iter().map(|(cache, classes)| (cache.clone(), of(classes))).collect()
    }

    /// Rays a second of simulated time.
    pub fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.cycles.0 as f64 * self.clock_mhz * 1e6
    }

    /// Share of its cycles in which a unit kind began an operation.
    pub fn utilization(&self, unit: &str) -> Option<f64> {
        let busy = self.units.get(unit)?.get(&Cause::Busy).copied().unwrap_or(0);
        let total = self.cycles.0 * self.unit_counts.get(unit)?;
        (total > 0).then(|| busy as f64 / total as f64)
    }
}
