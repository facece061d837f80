//! Tags compared with `Event`: they have no time, and perform the same operations.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};

use proptest::prelude::*;

use super::*;
use crate::engine::tests::synthetic::{STATIC, SyntheticRay, nodes};
use crate::machine::kinds::Kind;
use crate::machine::layout::{Element, Layout};
use crate::machine::shadow_cache::Place;
use crate::machine::writes::WritePolicy;
use crate::memory::allocation::NoAllocate;
use crate::memory::cache::Access;
use crate::memory::replacement::Policy;
use crate::memory::timeless::TimelessCache;
use crate::quantity::LineAddr;
use crate::sampling::covariates::Covariates;
use crate::sampling::path_tags::PathTags;
use crate::sampling::word_tags::WordTags;
use crate::stats::TrafficClass;
use crate::stream::{Decision, RayKind, Step, Stop};

/// The tags' covariates of a stream.
fn covariates(machine: &MachineSpec, header: &Header, stream: &[Item]) -> Covariates {
    let (mut path, mut words) = (PathTags::new(header, machine), WordTags::new(header, machine));
    let mut sum = Covariates::default();
    for item in stream {
        sum += match item {
            Item::Frame(info) => {
                path.begin_frame(info);
                words.begin_frame(info);
                continue;
            }
            Item::Rays(chunk) => {
                let outcome = path.piece(chunk, 0..chunk.len());
                let shift = path.shift_to(words.layout()).unwrap();
                words.piece(chunk, 0..chunk.len(), &outcome, shift).covariates
            }
            Item::End { policy, .. } => {
                let outcome = path.frame_end(policy);
                let shift = path.shift_to(words.layout()).unwrap();
                words.frame_end(policy, &outcome, shift).covariates
            }
        };
    }
    sum
}

/// Without registers and tables of hits, which tags leave out.
#[test]
fn tags_perform_the_operations_that_event_does() {
    check_many(
        300,
        || (machines(), streams()),
        |(mut machine, stream)| {
            (machine.shadow_cache.register, machine.shadow_cache.gather) = (num(0), num(0));
            let (header, whole) = (header(), on(&machine, &header(), "Event", &stream));
            let operations = Kind::ALL.map(|kind| whole.operations.get(kind.names().0).copied().unwrap_or(0));
            let covariates = covariates(&machine, &header, &stream).operations;
            let covariates = Kind::ALL.map(|kind| covariates[kind as usize] / kind.spec(&machine).interval);
            if operations == covariates { Ok(()) } else { Err(format!("Event {operations:?}, tags {covariates:?}")) }
        },
    );
}

/// The stream with all rays as primary rays, with their steps.
fn of_primary_rays(stream: &[Item]) -> Vec<Item> {
    let steps = |packed: &[u32]| Step::unpack_all(packed).collect::<Vec<_>>();
    let mut items = Vec::new();
    let (mut info, mut rays) = (FrameInfo::default(), Vec::new());
    for item in stream {
        match item {
            Item::Frame(frame) => info = *frame,
            Item::Rays(chunk) => rays.extend(chunk.rays().map(|ray| {
                let policy = ray.packed_policy().to_vec();
                SyntheticRay { policy, ..SyntheticRay::primary(steps(ray.packed_path())) }
            })),
            Item::End { policy, .. } => items.extend(frame(info, &std::mem::take(&mut rays), &steps(policy), 7)),
        }
    }
    items
}

/// With one ray in flight, accesses to the lines of nodes and lists have the same order in both. The L1s of a path then
/// miss as in `Event`, if all rays use the same units. (All rays are primary: in `Event`, children wait for shading.)
#[test]
fn tags_miss_what_event_misses_where_one_ray_is_in_flight() {
    let missed_by_all = AtomicU64::new(0);
    check_many(
        300,
        || (machines(), streams()),
        |(mut machine, stream)| {
            (machine.cores, machine.dispatcher.rays) = (num(1), num(1));
            (machine.shadow_cache.count, machine.shadow_cache.contexts) = (num(1), num(1));
            (machine.shadow_cache.register, machine.shadow_cache.gather) = (num(0), num(0));
            (machine.shadow_cache.place, machine.shadow_cache.writes) = (Place::Own, WritePolicy::Back);
            // Random replacement depends on the order of accesses in a set; the lines of one element have no fixed
            // order.
            for cache in [&mut machine.traversal.cache, &mut machine.list.cache] {
                if matches!(cache.replacement, Policy::Random { .. }) {
                    cache.replacement = Policy::Lru;
                }
            }
            if machine.line_bytes.get() < 64 {
                return Ok(());
            }
            let stream = of_primary_rays(&stream);
            let (header, whole) = (header(), on(&machine, &header(), "Event", &stream));
            let of_path = [Kind::Traversal, Kind::List];
            let misses = of_path.map(|kind| {
                let classes = whole.caches.get(kind.names().1).into_iter().flatten();
                classes.map(|(_, cache)| cache.counts.misses).sum::<u64>()
            });
            let missed = covariates(&machine, &header, &stream).missed;
            let missed = of_path.map(|kind| missed[kind as usize]);
            missed_by_all.fetch_add(misses.iter().sum(), Ordering::Relaxed);
            if misses == missed { Ok(()) } else { Err(format!("Event {misses:?}, tags {missed:?}")) }
        },
    );
    let all = missed_by_all.into_inner();
    assert!(all > 10_000, "{all} misses compare little");
}

/// Requests of the tags to the L2, computed plainly from the elements of each step, ray after ray, on a machine with
/// one unit of each kind. Children begin when their parents are done.
fn asked_plainly(machine: &MachineSpec, header: &Header, stream: &[Item]) -> Vec<(u64, bool)> {
    let mut layout = Layout::new(header, machine);
    let mut l1s = [Kind::Traversal, Kind::List, Kind::Intersection].map(|kind| {
        let spec = kind.spec(machine).cache;
        TimelessCache::new(spec.tags(machine.line_bytes.get()), spec.no_allocate)
    });
    let mut asked = Vec::new();
    let mut read = |l1: &mut TimelessCache, layout: &Layout, element: &Element| {
        let (first, lines) = layout.lines(element);
        for line in (first.0..first.0 + lines).map(LineAddr) {
            let (hit, victim) = l1.pass(line, element.class, Access::Read);
            asked.extend(victim.map(|victim| (victim.line.0, true)));
            asked.extend((!hit).then_some((line.0, false)));
        }
    };
    for item in stream {
        let mut perform = |steps: &[u32], is_path: bool| {
            let [traversal, lists, intersection] = &mut l1s;
            for step in Step::unpack_all(steps) {
                match step {
                    Step::Node(node) if is_path => read(traversal, &layout, &layout.node(node)),
                    Step::List(entry) if is_path => read(lists, &layout, &layout.list_entry(entry)),
                    Step::Triangle { slot, stop } => {
                        read(intersection, &layout, &layout.plane(slot));
                        if stop != Stop::Plane {
                            read(intersection, &layout, &layout.edges(slot));
                        }
                    }
                    _ => {}
                }
            }
        };
        match item {
            Item::Frame(info) => {
                layout.begin_frame(info);
                l1s.iter_mut().for_each(|l1| l1.drop_from(layout.dynamic_part()));
            }
            Item::Rays(chunk) => {
                let (primary, others): (Vec<usize>, Vec<usize>) =
                    (0..chunk.len()).partition(|&ray| chunk.head(ray).kind == RayKind::Primary);
                let child_of = |parent: usize| {
                    others.iter().copied().filter(move |&ray| ray - chunk.head(ray).parent as usize == parent)
                };
                for ray in primary {
                    let mut next = VecDeque::from([ray]);
                    while let Some(place) = next.pop_front() {
                        let ray = chunk.ray(place);
                        perform(ray.packed_path(), true);
                        perform(ray.packed_policy(), false);
                        next.extend(child_of(place));
                    }
                }
            }
            Item::End { policy, .. } => perform(policy, false),
        }
    }
    asked
}

/// Shortcuts of the paths' tags change no request: node lines computed without bytes, shared lines of a triangle's
/// plane and edges, sets of two lines.
#[test]
fn tags_ask_for_what_each_element_asks_for() {
    let no_reads = |classes: Vec<TrafficClass>| NoAllocate { reads: classes.into(), ..NoAllocate::NONE };
    let kept = prop_oneof![
        2 => Just(NoAllocate::NONE),
        1 => Just(no_reads(vec![TrafficClass::Triangle])),
        1 => Just(no_reads(vec![TrafficClass::Node])),
    ];
    check_many(
        300,
        || (machines(), streams(), kept.clone()),
        |(mut machine, stream, kept)| {
            machine.cores = num(1);
            (machine.traversal.count, machine.list.count, machine.intersection.count) = (num(1), num(1), num(1));
            (machine.traversal.cache.no_allocate, machine.intersection.cache.no_allocate) = (kept, kept);
            // With `place: Triangle`, entries would use the intersection units' L1s too.
            machine.shadow_cache.place = Place::Own;
            let header = header();
            let mut tags = PathTags::new(&header, &machine);
            tags.set_in_flight(1);
            let mut asked = Vec::new();
            for item in &stream {
                let outcome = match item {
                    Item::Frame(info) => {
                        tags.begin_frame(info);
                        continue;
                    }
                    Item::Rays(chunk) => tags.piece(chunk, 0..chunk.len()),
                    Item::End { policy, .. } => tags.frame_end(policy),
                };
                asked.extend(outcome.requests.list.iter().map(|request| (request.line.0, request.write)));
            }
            let plain = asked_plainly(&machine, &header, &stream);
            if asked == plain { Ok(()) } else { Err(format!("tags {asked:?}, plainly {plain:?}")) }
        },
    );
}

/// Faults of a stream in memory are reported as in whole replays, wherever windows lie.
#[test]
fn wrong_streams_are_refused_before_tags_take_them() {
    let machine = MachineSpec::default();
    let (header, plan) = (header(), Plan::new(0.5, Cut { pixels: 1, before: 2, own: 2, behind: 1 }, 0));
    let sampler = Sampler::new(Sampled::Event, &header);
    let error = |rays: &[SyntheticRay]| {
        let stream = frame(FrameInfo::default(), rays, &[], 64);
        let member = [Member { machine: &machine, plan: plan.clone() }];
        sampler.pass(&member, 0, &mut items(stream)).unwrap_err().to_string()
    };
    let beyond = [SyntheticRay::primary(nodes([STATIC]))];
    assert_eq!(error(&beyond), "node 4096 does not exist: the stream's header and frame announce 4096");
    let orphan = [SyntheticRay::primary(nodes([0])), SyntheticRay::shadow(2, Decision::Trace, Vec::new())];
    assert_eq!(error(&orphan), "ray 1 of a chunk has a parent outside its pixel group");
}
