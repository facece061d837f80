//! What was measured frame by frame: differences of counts at frames' ends, and their sums.

use std::collections::BTreeMap;
use std::ops::{AddAssign, Sub};

use serde::{Deserialize, Serialize};

use super::{CacheCounts, CacheStats, Cause, DramCounts, L1Counts, MachineStats};
use crate::quantity::{Bytes, Cycle};

/// What a machine measured in one frame, all classes of traffic together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameStats {
    /// The frame's number.
    pub frame: u32,
    /// Whether the frame warms caches and words up and is left out of all sums.
    pub warmup: bool,
    /// From the end of the frame that was replayed before to the end of this one.
    pub cycles: Cycle,
    /// Rays replayed, skipped ones not counted.
    pub rays: u64,
    /// Bytes moved a level, as [`MachineStats::bytes`].
    pub bytes: BTreeMap<String, Bytes>,
    /// Accesses a cache.
    pub caches: BTreeMap<String, CacheCounts>,
    /// Cycles of every unit kind by cause.
    pub units: BTreeMap<String, BTreeMap<Cause, u64>>,
    /// The DRAM's commands.
    pub dram: DramCounts,
}

impl FrameStats {
    /// A frame's `stats` without their classes.
    pub fn new(frame: u32, warmup: bool, stats: &MachineStats) -> Self {
        let accesses = |classes: &BTreeMap<_, CacheStats>| classes.values().map(|cache| cache.counts).sum();
        Self {
            frame,
            warmup,
            cycles: stats.cycles,
            rays: stats.rays,
            bytes: stats.bytes.keys().map(|level| (level.clone(), stats.moved(level))).collect(),
            caches: stats.caches.iter().map(|(cache, classes)| (cache.clone(), accesses(classes))).collect(),
            units: stats.units.clone(),
            dram: stats.dram,
        }
    }
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
        more(&mut self.queues, &other.queues);
        more(&mut self.latency, &other.latency);
        self.dram += other.dram;
    }

    /// The same run with nothing counted.
    pub fn nothing(&self) -> Self {
        self.since(self)
    }
}

type Counted<V> = BTreeMap<String, V>;

fn less<K: Clone + Ord, V: Copy + Sub<Output = V>>(
    now: &BTreeMap<K, V>,
    earlier: Option<&BTreeMap<K, V>>,
    stays: fn(&V) -> bool,
) -> BTreeMap<K, V> {
    let before = |key: &K| earlier.and_then(|earlier| earlier.get(key)).copied();
    let all = now.iter().map(|(key, &now)| (key.clone(), before(key).map_or(now, |before| now - before)));
    all.filter(|(_, value)| stays(value)).collect()
}

fn less_nested<K: Clone + Ord, V: Copy + Sub<Output = V>>(
    now: &Counted<BTreeMap<K, V>>,
    earlier: &Counted<BTreeMap<K, V>>,
    stays: fn(&V) -> bool,
) -> Counted<BTreeMap<K, V>> {
    now.iter().map(|(part, now)| (part.clone(), less(now, earlier.get(part), stays))).collect()
}

fn more<K: Clone + Ord, V: AddAssign + Copy + Default>(sum: &mut BTreeMap<K, V>, other: &BTreeMap<K, V>) {
    other.iter().for_each(|(key, &value)| *sum.entry(key.clone()).or_default() += value);
}

fn more_nested<K: Clone + Ord, V: AddAssign + Copy + Default>(
    sum: &mut Counted<BTreeMap<K, V>>,
    other: &Counted<BTreeMap<K, V>>,
) {
    other.iter().for_each(|(part, values)| more(sum.entry(part.clone()).or_default(), values));
}

impl Sub for CacheStats {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        let l1 = self.l1.map(|now| now - earlier.l1.unwrap_or_default());
        Self { counts: self.counts - earlier.counts, l1 }
    }
}

impl AddAssign for CacheStats {
    fn add_assign(&mut self, other: Self) {
        self.counts += other.counts;
        if let Some(more) = other.l1 {
            *self.l1.get_or_insert_with(L1Counts::default) += more;
        }
    }
}
