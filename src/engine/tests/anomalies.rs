//! Timing anomalies: changes of a machine that look like improvements but can make it slower, and the laws that hold
//! nevertheless. `docs/model/anomalies.md` has the table that these tests print with `--nocapture`.

use std::sync::{Arc, Mutex};

use super::agreement::{check_many, is_long};
use super::random::{machines, streams};
use super::*;
use crate::engine::lines::LineStream;
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};
use crate::machine::traffic::TrafficSpec;
use crate::memory::cache::CacheSpec;
use crate::memory::dram::spec::Model;
use crate::memory::replacement::Policy;
use crate::memory::tags::Contents;
use crate::stream::{Chunk, Totals};

/// A change of a machine.
struct Change {
    what: &'static str,
    /// Whether the change keeps the order of a single ray's accesses.
    is_orderly: bool,
    /// Changes the machine; returns whether it differs then.
    make: fn(&mut MachineSpec) -> bool,
}

const fn change(what: &'static str, make: fn(&mut MachineSpec) -> bool) -> Change {
    Change { what, is_orderly: false, make }
}

const fn orderly(what: &'static str, make: fn(&mut MachineSpec) -> bool) -> Change {
    Change { what, is_orderly: true, make }
}

/// Random machines, each with a stream. The table in the book has this many.
const CASES: u32 = 200;

const CHANGES: [Change; 12] = [
    change("a traversal unit more", |machine| more(&mut machine.traversal.count, 1)),
    change("an intersection unit more", |machine| more(&mut machine.intersection.count, 1)),
    change("a list unit more", |machine| more(&mut machine.list.count, 1)),
    change("a shadow-cache unit more", |machine| more(&mut machine.shadow_cache.count, 1)),
    change("twice as many rays in the pool", |machine| twice(&mut machine.dispatcher.rays)),
    orderly("traversal units that take half as long", |machine| {
        let unit = &mut machine.traversal;
        let latency = unit.latency.get().div_ceil(2).max(unit.interval.get());
        let changes = latency < unit.latency.get();
        unit.latency = num(latency);
        changes
    }),
    change("twice as many miss registers", |machine| {
        for cache in l1s(machine) {
            twice(&mut cache.mshrs);
        }
        l2s(machine, |cache| {
            twice(&mut cache.mshrs);
        });
        true
    }),
    change("twice as many ways in all L1s, with as many sets", |machine| {
        for cache in l1s(machine) {
            twice(&mut cache.ways);
            cache.bytes = size(2 * cache.bytes.get());
        }
        true
    }),
    change("twice as many ports of all L1s", |machine| {
        for cache in l1s(machine) {
            twice(&mut cache.ports);
        }
        true
    }),
    orderly("ideal L1s of one cycle", |machine| {
        for cache in l1s(machine) {
            (cache.contents, cache.latency) = (Contents::Ideal, num(1));
        }
        machine.shadow_cache.writes = WritePolicy::Back;
        true
    }),
    change("twice as many DRAM channels", |machine| {
        let channels = machine.dram.channels.get();
        machine.dram.channels = pow(2 * channels);
        machine.dram.model != Model::Banks
    }),
    change("a flat DRAM that answers in one cycle", |machine| {
        let changes = machine.dram.model == Model::Banks;
        machine.dram.model = Model::Flat { latency: num(1), bytes_per_cycle: None };
        changes
    }),
];

fn more<const LO: u64, const HI: u64>(field: &mut Within<LO, HI>, by: u64) -> bool {
    *field = num(field.get() + by);
    true
}

fn twice<const LO: u64, const HI: u64>(field: &mut Within<LO, HI>) -> bool {
    more(field, field.get())
}

pub(super) fn l1s(machine: &mut MachineSpec) -> [&mut CacheSpec; 4] {
    let MachineSpec { traversal, list, intersection, shadow_cache, .. } = machine;
    [&mut traversal.cache, &mut list.cache, &mut intersection.cache, &mut shadow_cache.cache]
}

fn l2s(machine: &mut MachineSpec, mut change: impl FnMut(&mut BankedSpec)) {
    match &mut machine.l2 {
        L2Spec::Unified(cache) => change(cache),
        L2Spec::Split(homes) => {
            let changed = homes.iter().map(|(name, home)| {
                let mut home = home.clone();
                change(&mut home.cache);
                (name.to_owned(), home)
            });
            *homes = changed.collect();
        }
    }
}

/// Ratios of cycles after a change to cycles before it.
#[derive(Default)]
struct Found {
    cases: usize,
    ratios: Vec<f64>,
}

impl Found {
    fn slower(&self) -> usize {
        self.ratios.iter().filter(|&&ratio| ratio > 1.0).count()
    }

    fn row(mut self, what: &str) -> String {
        // Threads finish in any order, and a floating-point sum depends on the order.
        self.ratios.sort_by(f64::total_cmp);
        let worst = self.ratios.last().copied().unwrap_or(1.0).max(1.0);
        let mean = (self.ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / self.cases as f64).exp();
        let share = 100.0 * self.slower() as f64 / self.cases as f64;
        let [worst, mean] = [worst, mean].map(|ratio| 100.0 * (ratio - 1.0));
        format!("| {what} | {} | {share:.1} % | {worst:+.1} % | {mean:+.1} % |", self.cases)
    }
}

#[test]
fn what_looks_better_can_be_slower() {
    let found = Mutex::new(CHANGES.map(|_| Found::default()));
    check_many(
        CASES,
        || (machines(), streams()),
        |(machine, stream)| {
            let before = replayed(&machine, stream.clone());
            for (Change { what, make, .. }, found) in CHANGES.iter().zip(found.lock().unwrap().iter_mut()) {
                let mut changed = machine.clone();
                if make(&mut changed) && changed.check().is_ok() {
                    found.cases += 1;
                    let after = replayed(&changed, stream.clone());
                    found.ratios.push(after.cycles.0 as f64 / before.cycles.0 as f64);
                    check_work(&before, &after, &machine).map_err(|why| format!("{what}: {why}"))?;
                }
            }
            Ok(())
        },
    );
    println!("| change | machines | slower | worst | mean |\n|---|---|---|---|---|");
    let book = include_str!("../../../docs/model/anomalies.md");
    let mut others = Vec::new();
    for (Change { what, .. }, found) in CHANGES.iter().zip(found.into_inner().unwrap()) {
        assert!(found.cases > 20, "{what}: {} machines only", found.cases);
        let row = found.row(what);
        println!("{row}");
        // The long suite has more machines than the book's table.
        if !is_long() && !book.contains(&row) {
            others.push(row);
        }
    }
    assert!(others.is_empty(), "docs/model/anomalies.md has other rows than these:\n{}", others.join("\n"));
}

/// A change of timing does not change the work of traversal, list and intersection units, except accesses to words in
/// intersection units.
fn check_work(before: &MachineStats, after: &MachineStats, machine: &MachineSpec) -> Result<(), String> {
    let of_words = machine.shadow_cache.place == Place::Triangle;
    let is_work = |name: &str| !(name.contains("shadow_cache") || of_words && name.contains("intersection"));
    let work = |stats: &MachineStats| {
        let operations = stats.operations.iter().filter(|(unit, _)| is_work(unit));
        let requested = stats.bytes.iter().filter(|(level, _)| level.starts_with("l1_") && is_work(level));
        let [operations, requested] = [
            format!("{:?}", operations.collect::<Vec<_>>()),
            format!("{requested:?}", requested = requested.collect::<Vec<_>>()),
        ];
        format!("{} rays, {operations}, {requested}", stats.rays)
    };
    let (before, after) = (work(before), work(after));
    if before == after { Ok(()) } else { Err(format!("{before} becomes {after}")) }
}

/// True LRU keeps all lines that a cache with the same sets and fewer ways keeps (Mattson et al. 1970): the same
/// accesses never miss more with more ways. Another order of rays gives other accesses: the law holds for a line
/// stream, not for a machine.
#[test]
fn more_ways_of_lru_miss_no_more_of_the_same_accesses() {
    let compared = Mutex::new(0);
    check_many(
        2 * CASES,
        || (machines(), streams()),
        |(machine, stream)| {
            for cache in Kind::ALL.map(|kind| kind.names().1) {
                let mut machine = machine.clone();
                machine.shadow_cache = ShadowCacheSpec::default();
                let mut lines = LineStream::new(&machine, &header(), cache).map_err(|error| error.to_string())?;
                let line = machine.line_bytes.get();
                let of = |ways: u64| CacheSpec {
                    contents: Contents::Tags,
                    bytes: size(4 * ways * line),
                    ways: num(ways),
                    replacement: Policy::Lru,
                    ..CacheSpec::DEFAULT
                };
                let mut caches = [1, 2, 3, 4, 8].map(|ways| (of(ways).tags(line), 0u64));
                for item in &stream {
                    lines.item(item, |line, write| {
                        for (tags, misses) in &mut caches {
                            if !tags.access(line, write) {
                                *misses += 1;
                                tags.fill(line, TrafficClass::Node, write);
                            }
                        }
                    });
                }
                let misses = caches.map(|(_, misses)| misses);
                *compared.lock().unwrap() += usize::from(misses[0] > misses[4]);
                if !misses.is_sorted_by(|fewer, more| fewer >= more) {
                    return Err(format!("{cache}: {misses:?} misses"));
                }
            }
            Ok(())
        },
    );
    let compared = compared.into_inner().unwrap();
    assert!(compared > 40, "more ways matter in {compared} cases only");
}

/// One ray at a time on a flat DRAM, without host traffic and with shading in one cycle: changes that keep the order of
/// accesses never make it slower. (Another unit has a cold L1. More MSHRs reorder the lines of a fetch. DRAM banks have
/// rows that an earlier request left open or closed. Rays in long shading may be reordered with the next ray.)
#[test]
fn one_ray_at_a_time_knows_no_anomaly() {
    check_many(
        CASES,
        || (machines(), streams()),
        |(mut machine, stream)| {
            let stream = without_policy(&stream);
            machine.cores = num(1);
            machine.dispatcher.rays = num(1);
            machine.dispatcher.shading_cycles = num(1);
            machine.traffic = TrafficSpec::default();
            machine.dram.model = Model::Flat { latency: num(40), bytes_per_cycle: Some(size(8)) };
            let before = replayed(&machine, stream.clone());
            for Change { what, make, .. } in CHANGES.iter().filter(|change| change.is_orderly) {
                let mut changed = machine.clone();
                if make(&mut changed) && changed.check().is_ok() {
                    let after = replayed(&changed, stream.clone());
                    if after.cycles > before.cycles {
                        return Err(format!("{what}: {} cycles become {}", before.cycles.0, after.cycles.0));
                    }
                }
            }
            Ok(())
        },
    );
}

/// The stream without the policy's steps, which run beside the next ray.
pub(super) fn without_policy(stream: &[Item]) -> Vec<Item> {
    let mut counted = Totals::default();
    let without = |item: &Item| match item {
        Item::Frame(_) => item.clone(),
        Item::Rays(chunk) => {
            let mut paths = Chunk::default();
            chunk.rays().for_each(|ray| paths.push(ray.head, ray.packed_path(), &[]));
            counted.count_chunk(&paths);
            Item::Rays(Arc::new(paths))
        }
        Item::End { .. } => Item::End { policy: Arc::default(), totals: std::mem::take(&mut counted) },
    };
    stream.iter().map(without).collect()
}
