//! `Profile`: the counts that it must share with `Event` on any machine, and its error on the recorded stream.

use std::sync::Arc;

use super::agreement::check_many;
use super::random::{machines, streams};
use super::recorded::on;
use super::synthetic::header;
use super::*;
use crate::engine::tally::{BankTally, PerClass};
use crate::machine::shadow_cache::{FrameEnd, Place};
use crate::machine::word_traffic::LatchedCopy;
use crate::memory::tags::Contents;
use crate::stream::{Chunk, StoreEntries, Totals};

/// Work that does not depend on timing: rays, operations, accesses, requested bytes. The run itself checks counts,
/// conservation and bounds.
#[test]
fn profile_does_the_same_work_as_event_on_any_machine() {
    check_many(
        200,
        || (machines(), streams()),
        |(mut machine, stream)| {
            let unit = &mut machine.shadow_cache;
            (unit.place, unit.register, unit.frame_end) = (Place::Own, num(0), FrameEnd::List);
            // Gathering depends on timing.
            (unit.gather, unit.latched) = (num(0), LatchedCopy::Free);
            // Operations that begin together make one cycle busy.
            unit.width = num(1);
            if unit.cache.contents == Contents::Ideal {
                unit.writes = WritePolicy::Back;
            }
            let [profile, event] = ["Profile", "Event"].map(|rung| on(&machine, &header(), rung, &stream));
            let work = |stats: &MachineStats| {
                let busy: Vec<_> = stats.units.values().map(|causes| causes[&Cause::Busy]).collect();
                let l1s = stats.caches.iter().filter(|(name, _)| name.starts_with("l1"));
                let accesses: Vec<_> = l1s.flat_map(|(_, classes)| classes.values().map(|it| it.accesses)).collect();
                let asked: Vec<_> = stats.bytes.iter().filter(|(name, _)| name.starts_with("l1")).collect();
                format!("{:?}", (stats.rays, &busy[1..], accesses, asked))
            };
            if work(&profile) == work(&event) {
                Ok(())
            } else {
                Err(format!("Profile {}\nEvent {}", work(&profile), work(&event)))
            }
        },
    );
}

/// On any machine, attribution changes nothing, and each miss is attributed to one ray: the misses of attributed rays
/// and of the other rays sum to all misses.
#[test]
fn misses_are_those_of_the_rays_that_ask() {
    /// Cycles; then misses of the L1s and read misses of the L2: all misses and those of attributed rays.
    fn missed(engine: &mut dyn Engine, machine: &MachineSpec, items: &[Item]) -> (u64, [[PerClass<u64>; 2]; 2]) {
        let tally = replay(engine, machine, &mut items.iter().cloned().map(Ok), None).unwrap();
        let units = || tally.units.iter().flatten();
        let sum = |of: fn(&UnitTally, usize) -> u64| std::array::from_fn(|class| units().map(|it| of(it, class)).sum());
        let banks = |of: fn(&BankTally, usize) -> u64| {
            std::array::from_fn(|class| tally.banks.iter().map(|it| of(it, class)).sum())
        };
        let l1s = [sum(|unit, class| unit.cache[class].misses), sum(|unit, class| unit.attributed[class])];
        (
            tally.cycles,
            [l1s, [banks(|bank, class| bank.served.missed[class]), banks(|bank, class| bank.served.attributed[class])]],
        )
    }
    check_many(
        100,
        || (machines(), streams()),
        |(mut machine, stream)| {
            // End-of-frame steps belong to no ray: the streams have none.
            (machine.shadow_cache.frame_end, machine.shadow_cache.latched) = (FrameEnd::List, LatchedCopy::Free);
            // Marks every other chunk, then the other chunks.
            let attributed = |odd: usize| -> Vec<Item> {
                let mut totals = Totals::default();
                let mark = |(at, item): (usize, &Item)| match item {
                    Item::Rays(chunk) => {
                        chunk.rays().for_each(|ray| totals.count(&ray));
                        let mut chunk = Chunk::clone(chunk);
                        if at % 2 == odd {
                            chunk.attribute();
                        }
                        Item::Rays(Arc::new(chunk))
                    }
                    Item::End { .. } => Item::End { policy: Arc::default(), totals: std::mem::take(&mut totals) },
                    frame => frame.clone(),
                };
                stream.iter().enumerate().map(mark).collect()
            };
            let streams = [attributed(0), attributed(1)];
            let header = header();
            let event = |items: &Vec<Item>| missed(&mut Event::new(&machine, &header), &machine, items);
            let mut by = vec![("Event", streams.each_ref().map(event))];
            let profile = |items: &Vec<Item>| missed(&mut Profile::new(&machine, &header), &machine, items);
            by.push(("Profile", streams.each_ref().map(profile)));
            for (engine, [(cycles, levels), (as_many, same_levels)]) in by {
                // A write from a register belongs to no ray.
                let of_scene = [TrafficClass::Node, TrafficClass::List, TrafficClass::Triangle];
                let is_right = |class: TrafficClass, all: u64, sum: u64| {
                    sum == all || machine.shadow_cache.register.get() > 0 && !of_scene.contains(&class) && sum < all
                };
                let levels = levels.iter().zip(&same_levels);
                let are_right = levels.clone().all(|([all, some], [same, others])| {
                    let sums = some.iter().zip(others).map(|(some, others)| some + others);
                    let mut classes = TrafficClass::ALL.into_iter().zip(all).zip(sums);
                    all == same && classes.all(|((class, &all), sum)| is_right(class, all, sum))
                });
                if cycles != as_many || !are_right {
                    return Err(format!("{engine}: {cycles} {as_many}, {:?}", levels.collect::<Vec<_>>()));
                }
            }
            Ok(())
        },
    );
}

/// A policy without stores records no accesses to stores.
#[test]
fn every_level_replays_a_stream_without_stores() {
    let (machine, header) = (MachineSpec::default(), Header { stores: StoreEntries::default(), ..header() });
    let stream = one_frame(&[SyntheticRay::primary(nodes(0..9))]);
    for level in [Level::Bound, Level::Profile, Level::Event, Level::Cycle] {
        let stats = run(&machine, level, &header, &stream).unwrap_or_else(|error| panic!("{level}: {error}"));
        assert!(stats.cycles.0 > 0, "{level}");
    }
}
