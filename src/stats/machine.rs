//! The measurements of one machine on one stream.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::accuracy::{Accuracy, Bounds, Limit};
use super::choice::Choice;
use super::counts::{CacheCounts, CacheStats, DramCounts, LatencyCounts, QueueCounts};
use super::difference::{less, less_nested, more, more_nested};
use super::energy::Energy;
use super::frames::FrameStats;
use super::residuals::Residuals;
use super::traffic::{Cause, TrafficClass};
use crate::quantity::{Bytes, Cycle};

/// The measurements of one machine on one stream.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineStats {
    /// Time from the first ray to the last write-back.
    pub cycles: Cycle,
    /// The machine's clock.
    pub clock_mhz: f64,
    /// Rays replayed, skipped ones not counted.
    pub rays: u64,
    /// Bytes moved at each level (`l1_traversal`, ..., `l2`, `dram`), by class. A level's bytes are those moved between
    /// it and the level above (towards the units).
    pub bytes: BTreeMap<String, BTreeMap<TrafficClass, Bytes>>,
    /// Accesses of each kind of caches (all instances together), by class.
    pub caches: BTreeMap<String, BTreeMap<TrafficClass, CacheStats>>,
    /// Cycles of every unit kind, summed over its instances, by cause.
    pub units: BTreeMap<String, BTreeMap<Cause, u64>>,
    /// Operations that units of every kind began; a wide unit can begin several in a cycle.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub operations: BTreeMap<String, u64>,
    /// Instances of every unit kind: the causes of a kind sum to `cycles` times this.
    pub unit_counts: BTreeMap<String, u64>,
    /// Queues between parts, by the part that takes from them; only of levels with queues.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub queues: BTreeMap<String, QueueCounts>,
    /// Latencies by kind of rays; only of levels that know them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub latency: BTreeMap<String, LatencyCounts>,
    /// The DRAM's commands.
    pub dram: DramCounts,
    /// The DRAM's channels, part, page policy and address mapping, as text.
    pub dram_organization: String,
    /// Peak bandwidth of the DRAM in bytes a machine cycle; `None` if a flat DRAM has no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dram_peak_bytes_per_cycle: Option<f64>,
    /// How far these figures may be from the truth.
    #[serde(default)]
    pub accuracy: Accuracy,
    /// Half the widths of the 95 % intervals of estimated figures, by the figure's path: `bytes.l2.node`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub half_widths: BTreeMap<String, f64>,
    /// The residuals of a sample's windows, for comparisons.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residuals: Option<Residuals>,
    /// What `Auto` did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<Choice>,
    /// The replayed frames, warm-up frames included; only of runs that count frames separately. All other figures are
    /// the sums over the measured frames.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<FrameStats>,
    /// Energy; absent where the DRAM's energy is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
    /// Bounds that no machine can leave.
    #[serde(default)]
    pub bounds: Option<Bounds>,
    /// The limit of culling, where it was computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub oracle: Option<Limit>,
}

impl MachineStats {
    /// The same figures without a claim how far off they are: of a sample by a level that is not exact, whose windows
    /// tell how far it is from that level, and not from the machine.
    pub fn without_claims(self) -> Self {
        Self { accuracy: Accuracy::Unknown, half_widths: BTreeMap::new(), residuals: None, ..self }
    }

    /// Bytes moved at a level, all classes together; 0 if there is no such level.
    pub fn moved(&self, level: &str) -> Bytes {
        self.bytes.get(level).into_iter().flat_map(|classes| classes.values()).copied().sum()
    }

    /// Bytes moved between the L1s and all caches of the L2, whose names begin with `l2`.
    pub fn moved_l2(&self) -> Bytes {
        let levels = self.bytes.iter().filter(|(level, _)| level.starts_with("l2"));
        levels.flat_map(|(_, classes)| classes.values()).copied().sum()
    }

    /// Names of the caches that words may meet first: an L1, or any cache of the L2.
    pub fn first_caches(&self) -> impl Iterator<Item = &str> {
        let l2s = self.caches.keys().map(String::as_str).filter(|name| name.starts_with("l2"));
        ["l1_shadow_cache", "l1_intersection"].into_iter().chain(l2s)
    }

    /// Half the width of the interval of a figure's ratio to that of another run; `None` if it is not known, or if both
    /// runs are exact. `figure` is the index in [`Accuracy::shares`]. For samples of the same windows it comes from
    /// their differences; otherwise both relative half widths are added (worst case).
    pub fn half_width_of_ratio(&self, before: &Self, figure: usize, ratio: f64) -> Option<f64> {
        half_width_of_ratio(
            [(&self.accuracy, self.residuals.as_ref()), (&before.accuracy, before.residuals.as_ref())],
            figure,
            ratio,
        )
    }

    /// Hits over accesses of each kind of caches, by class, where there are accesses.
    pub fn hit_rates(&self) -> BTreeMap<String, BTreeMap<TrafficClass, f64>> {
        let of = |classes: &BTreeMap<TrafficClass, CacheStats>| {
            classes.iter().filter_map(|(&class, cache)| Some((class, cache.counts.hit_rate()?))).collect()
        };
        self.caches.iter().map(|(cache, classes)| (cache.clone(), of(classes))).collect()
    }

    /// Rays a second of simulated time.
    pub fn rays_per_second(&self) -> f64 {
        self.rays as f64 / self.cycles.0 as f64 * self.clock_mhz * 1e6
    }

    /// Share of the cycles in which a unit kind began an operation.
    pub fn utilization(&self, unit: &str) -> Option<f64> {
        let busy = self.units.get(unit)?.get(&Cause::Busy).copied().unwrap_or(0);
        let total = self.cycles.0 * self.unit_counts.get(unit)?;
        (total > 0).then(|| busy as f64 / total as f64)
    }
}

/// Half the width of the interval of a figure's ratio to its value before, from accuracies and residuals; see
/// [`MachineStats::half_width_of_ratio`].
pub(crate) fn half_width_of_ratio(
    [(accuracy, residuals), (accuracy_before, before)]: [(&Accuracy, Option<&Residuals>); 2],
    figure: usize,
    ratio: f64,
) -> Option<f64> {
    let [own, others] = [accuracy.shares()?[figure], accuracy_before.shares()?[figure]];
    let is_exact = *accuracy == Accuracy::Exact && *accuracy_before == Accuracy::Exact;
    let paired = residuals.zip(before).and_then(|(residuals, before)| residuals.of_ratio(before, figure));
    (!is_exact).then_some(ratio * paired.unwrap_or(own + others))
}

impl MachineStats {
    /// What was counted after `earlier` counts of the same run. Classes in which nothing was counted are absent.
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            cycles: self.cycles - earlier.cycles,
            rays: self.rays - earlier.rays,
            bytes: less_nested(&self.bytes, &earlier.bytes, |bytes| *bytes != Bytes(0)),
            caches: less_nested(&self.caches, &earlier.caches, |cache| cache.counts != CacheCounts::default()),
            units: less_nested(&self.units, &earlier.units, |_| true),
            operations: less(&self.operations, Some(&earlier.operations), |_| true),
            queues: less(&self.queues, Some(&earlier.queues), |_| true),
            latency: less(&self.latency, Some(&earlier.latency), |latency| latency.rays > 0),
            dram: self.dram - earlier.dram,
            ..self.clone()
        }
    }

    /// Adds the counts of other frames of the same run.
    pub fn add(&mut self, other: &Self) {
        self.cycles += other.cycles;
        self.rays += other.rays;
        more_nested(&mut self.bytes, &other.bytes);
        more_nested(&mut self.caches, &other.caches);
        more_nested(&mut self.units, &other.units);
        more(&mut self.operations, &other.operations);
        more(&mut self.queues, &other.queues);
        more(&mut self.latency, &other.latency);
        self.dram += other.dram;
    }

    /// The same run with nothing counted.
    pub fn nothing(&self) -> Self {
        self.since(self)
    }

    /// These counts as the counts of one frame with `answered` rays, all classes together.
    pub fn as_frame(&self, frame: u32, warmup: bool, answered: u64) -> FrameStats {
        let accesses = |classes: &BTreeMap<_, CacheStats>| classes.values().map(|cache| cache.counts).sum();
        FrameStats {
            frame,
            warmup,
            cycles: self.cycles,
            rays: self.rays,
            answered,
            bytes: self.bytes.keys().map(|level| (level.clone(), self.moved(level))).collect(),
            caches: self.caches.iter().map(|(cache, classes)| (cache.clone(), accesses(classes))).collect(),
            units: self.units.clone(),
            dram: self.dram,
            energy: self.energy.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_may_meet_any_cache_of_a_split_l2_first() {
        let caches = ["l1_traversal", "l2_scene", "l2_words", "l1_shadow_cache"];
        let caches = caches.map(|name| (name.to_owned(), BTreeMap::new()));
        let stats = MachineStats { caches: caches.into(), ..MachineStats::default() };
        let first: Vec<&str> = stats.first_caches().collect();
        assert_eq!(first, ["l1_shadow_cache", "l1_intersection", "l2_scene", "l2_words"]);
    }
}
