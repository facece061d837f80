//! The counters of [`MachineStats`] as numbers that can be subtracted and scaled.

use std::collections::BTreeMap;

use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::quantity::{Bytes, Cycle};
use crate::stats::{
    CacheCounts, CacheStats, Cause, DramCounts, L1Counts, LatencyCounts, MachineStats, QueueCounts, TrafficClass,
};

/// The figures of a run.
pub(crate) type Figures = BTreeMap<Figure, f64>;

/// The name of a number of a run. A counter of a group is identified by its place in the group's declaration.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Figure {
    /// Cycles.
    Cycles,
    /// Rays replayed.
    Rays,
    /// Bytes between a level and the one above.
    Bytes(MemoryLevel, TrafficClass),
    /// A counter of the caches of a level.
    Cache(MemoryLevel, TrafficClass, usize),
    /// A counter that only L1s have.
    L1(MemoryLevel, TrafficClass, usize),
    /// Cycles of a kind of units, by cause.
    Unit(String, Cause),
    /// Operations of a kind of units.
    Operations(String),
    /// A counter of a kind of queues.
    Queue(String, usize),
    /// A counter of a kind of rays; the longest latency is a maximum and no figure.
    Latency(String, usize),
    /// A counter of the DRAM.
    Dram(usize),
    /// Bytes between the L1s and all caches of the L2: a sum that no field of the statistics holds.
    L2Bytes,
    /// Bytes of the DRAM, all classes together.
    DramBytes,
}

/// A level of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum MemoryLevel {
    /// The FIFOs of the dispatcher.
    Fifos,
    /// The buffer of rays and hits on the chip.
    RayBuffer,
    /// The L1s of a kind of units.
    L1(Kind),
    /// A cache of the L2, by its place in `L2Spec::caches`.
    L2(usize),
    /// The DRAM.
    Dram,
}

/// The names of a machine's levels in its statistics.
pub(crate) struct Levels(Vec<(MemoryLevel, String)>);

impl Levels {
    /// The levels of `machine`.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        let l1s = Kind::ALL.map(|kind| (MemoryLevel::L1(kind), kind.names().1.to_owned()));
        let l2s = machine.l2.caches().into_iter().enumerate().map(|(home, (name, _))| (MemoryLevel::L2(home), name));
        let others =
            [(MemoryLevel::Fifos, "fifos"), (MemoryLevel::RayBuffer, "ray_buffer"), (MemoryLevel::Dram, "dram")];
        let others = others.map(|(level, name)| (level, name.to_owned()));
        Self(l1s.into_iter().chain(l2s).chain(others).collect())
    }

    fn name(&self, level: MemoryLevel) -> &str {
        self.0.iter().find(|(one, _)| *one == level).map_or("", |(_, name)| name)
    }

    /// Each level with its value in `parts`.
    fn of<'a, V>(&'a self, parts: &'a BTreeMap<String, V>) -> impl Iterator<Item = (MemoryLevel, &'a V)> {
        self.0.iter().filter_map(|(level, name)| Some((*level, parts.get(name)?)))
    }

    /// All counters of `stats`, and the two sums.
    pub(crate) fn figures(&self, stats: &MachineStats) -> Figures {
        let mut figures = Figures::new();
        let mut put = |figure: Figure, count: u64| {
            figures.insert(figure, count as f64);
        };
        put(Figure::Cycles, stats.cycles.0);
        put(Figure::Rays, stats.rays);
        put(Figure::L2Bytes, stats.moved_l2().0);
        put(Figure::DramBytes, stats.moved("dram").0);
        for (level, classes) in self.of(&stats.bytes) {
            classes.iter().for_each(|(&class, bytes)| put(Figure::Bytes(level, class), bytes.0));
        }
        for (level, classes) in self.of(&stats.caches) {
            for (&class, CacheStats { counts, l1 }) in classes {
                places(&counts.values(), |place| Figure::Cache(level, class, place), &mut put);
                let l1 = l1.map(|l1| l1.values());
                places(l1.as_ref().map_or(&[], |l1| l1), |place| Figure::L1(level, class, place), &mut put);
            }
        }
        for (unit, causes) in &stats.units {
            causes.iter().for_each(|(&cause, &cycles)| put(Figure::Unit(unit.clone(), cause), cycles));
        }
        stats.operations.iter().for_each(|(unit, &count)| put(Figure::Operations(unit.clone()), count));
        for (queue, counts) in &stats.queues {
            places(&counts.values(), |place| Figure::Queue(queue.clone(), place), &mut put);
        }
        for (rays, counts) in &stats.latency {
            let summed = &counts.values()[..LatencyCounts::SUMMED];
            places(summed, |place| Figure::Latency(rays.clone(), place), &mut put);
        }
        places(&stats.dram.values(), Figure::Dram, &mut put);
        figures
    }

    /// `stats` with these figures, rounded.
    pub(crate) fn with<'a>(
        &self,
        stats: &MachineStats,
        figures: impl Iterator<Item = (&'a Figure, f64)>,
    ) -> MachineStats {
        let mut stats = stats.clone();
        for (figure, value) in figures {
            let count = value.max(0.0).round() as u64;
            let name = |level: &MemoryLevel| self.name(*level).to_owned();
            match figure {
                Figure::Cycles => stats.cycles = Cycle(count),
                Figure::Rays => stats.rays = count,
                Figure::Bytes(level, class) => {
                    stats.bytes.entry(name(level)).or_default().insert(*class, Bytes(count));
                }
                Figure::Cache(level, class, place) => {
                    let cache = stats.caches.entry(name(level)).or_default().entry(*class).or_default();
                    cache.counts = CacheCounts::from_values(changed(cache.counts.values(), *place, count));
                }
                Figure::L1(level, class, place) => {
                    let cache = stats.caches.entry(name(level)).or_default().entry(*class).or_default();
                    let l1 = cache.l1.unwrap_or_default();
                    cache.l1 = Some(L1Counts::from_values(changed(l1.values(), *place, count)));
                }
                Figure::Unit(unit, cause) => {
                    stats.units.entry(unit.clone()).or_default().insert(*cause, count);
                }
                Figure::Operations(unit) => {
                    stats.operations.insert(unit.clone(), count);
                }
                Figure::Queue(queue, place) => {
                    let counts = stats.queues.entry(queue.clone()).or_default();
                    *counts = QueueCounts::from_values(changed(counts.values(), *place, count));
                }
                Figure::Latency(rays, place) => {
                    let counts = stats.latency.entry(rays.clone()).or_default();
                    *counts = LatencyCounts::from_values(changed(counts.values(), *place, count));
                }
                Figure::Dram(place) => {
                    stats.dram = DramCounts::from_values(changed(stats.dram.values(), *place, count));
                }
                Figure::L2Bytes | Figure::DramBytes => {}
            }
        }
        stats
    }

    /// The path of a figure in a report, such as `bytes.l2.node`; `None` for the two sums.
    pub(crate) fn path(&self, figure: &Figure) -> Option<String> {
        let cache = |level: &MemoryLevel, class: &TrafficClass, counter: &str| {
            format!("caches.{}.{}.{counter}", self.name(*level), class.name())
        };
        Some(match figure {
            Figure::Cycles => "cycles".into(),
            Figure::Rays => "rays".into(),
            Figure::Bytes(level, class) => format!("bytes.{}.{}", self.name(*level), class.name()),
            Figure::Cache(level, class, place) => cache(level, class, CacheCounts::DECLARED[*place].name),
            Figure::L1(level, class, place) => cache(level, class, L1Counts::DECLARED[*place].name),
            Figure::Unit(unit, cause) => format!("units.{unit}.{}", cause.name()),
            Figure::Operations(unit) => format!("operations.{unit}"),
            Figure::Queue(queue, place) => format!("queues.{queue}.{}", QueueCounts::DECLARED[*place].name),
            Figure::Latency(rays, place) => format!("latency.{rays}.{}", LatencyCounts::DECLARED[*place].name),
            Figure::Dram(place) => format!("dram.{}", DramCounts::DECLARED[*place].name),
            Figure::L2Bytes | Figure::DramBytes => return None,
        })
    }
}

/// Adds the counters of a group.
fn places(values: &[u64], figure: impl Fn(usize) -> Figure, put: &mut impl FnMut(Figure, u64)) {
    values.iter().enumerate().for_each(|(place, &count)| put(figure(place), count));
}

/// `values` with `count` at `place`.
fn changed<const N: usize>(mut values: [u64; N], place: usize, count: u64) -> [u64; N] {
    values[place] = count;
    values
}

/// The figures of `after` less those of `before`.
pub(crate) fn difference(after: &Figures, before: &Figures) -> Figures {
    after.iter().map(|(figure, value)| (figure.clone(), value - before.get(figure).copied().unwrap_or(0.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::agreement::check_many;
    use crate::engine::tests::random::{machines, streams};
    use crate::engine::tests::recorded::{on, quickstart, shipped};
    use crate::engine::tests::synthetic::header;

    /// All counters can be written back, and each path is that of the report.
    fn check(machine: &MachineSpec, stats: &MachineStats) -> Result<(), String> {
        let levels = Levels::new(machine);
        let figures = levels.figures(stats);
        let nothing = MachineStats { frames: stats.frames.clone(), ..stats.nothing() };
        let mut again = levels.with(&nothing, figures.iter().map(|(figure, &value)| (figure, value)));
        // The longest latencies are no figures.
        for (kind, counts) in &mut again.latency {
            counts.most = stats.latency[kind].most;
        }
        if again != *stats {
            return Err(format!("{stats:?}\nbecomes {again:?}"));
        }
        let json = serde_json::to_value(stats).unwrap();
        for (figure, &value) in &figures {
            let Some(path) = levels.path(figure) else { continue };
            let found = path.split('.').fold(&json, |place, word| &place[word]);
            if found.as_u64() != Some(value as u64) {
                return Err(format!("{path}: {found} and {value}"));
            }
        }
        Ok(())
    }

    #[test]
    fn figures_are_all_counters_of_a_run() {
        let (header, stream) = quickstart();
        let machine = shipped("small");
        check(&machine, &on(&machine, &header, "Event", &stream)).unwrap();
    }

    /// A level whose name the figures miss would be missing in every sample: any L2, lists, any place of words.
    #[test]
    fn figures_are_all_counters_of_any_machine() {
        check_many(
            60,
            || (machines(), streams()),
            |(machine, stream)| check(&machine, &on(&machine, &header(), "Event", &stream)),
        );
    }
}
