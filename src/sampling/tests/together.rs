//! Machines on the same pass: each gives the same result as alone, whatever it shares.

use super::super::cutter::Cutter;
use super::super::grow::{Goal, sample_until};
use super::super::job_cache::JobCache;
use super::super::lane::{Lane, OnLane, lanes, machines_of_lanes};
use super::super::windows::Windows;
use super::*;
use crate::machine::shadow_cache::Place;
use crate::machine::stores::StoreLayout;
use crate::machine::word_traffic::LatchedCopy;
use crate::memory::l2::L2Spec;

/// `small` with few rays, and machines that share all of its tags, those of its L1s, those of its path, or none.
fn some() -> Vec<MachineSpec> {
    let mut base = shipped("small");
    base.dispatcher.rays = num(16);
    let with = |change: fn(&mut MachineSpec)| {
        let mut machine = base.clone();
        change(&mut machine);
        machine
    };
    vec![
        base.clone(),
        with(|machine| machine.traversal.cache.mshrs = num(2)),
        with(|machine| machine.shadow_cache.register = num(4)),
        with(|machine| {
            if let L2Spec::Unified(l2) = &mut machine.l2 {
                l2.bytes = crate::ranged::Size::new(65536).unwrap();
            }
        }),
        with(|machine| machine.shadow_cache.count = num(2)),
        with(|machine| machine.traversal.cache.bytes = crate::ranged::Size::new(2048).unwrap()),
        with(|machine| machine.shadow_cache.place = Place::L2),
        // Its single shadow-cache unit holds rays up.
        with(|machine| machine.shadow_cache.interval = num(64)),
        with(|machine| machine.shadow_cache.place = Place::Triangle),
        with(|machine| machine.shadow_cache.layout = StoreLayout::Record),
        // Its stores are larger: the dynamic part has other addresses.
        with(|machine| machine.shadow_cache.latched = LatchedCopy::Buffers),
    ]
}

#[test]
fn machines_share_the_tags_that_are_equal() {
    let machines = some();
    let (header, _) = quickstart();
    let found = machines_of_lanes(&header, &machines);
    let alone = |machine| vec![vec![vec![machine]]];
    let path = vec![vec![vec![0, 1, 2], vec![3]], vec![vec![4]], vec![vec![6]], vec![vec![7]], vec![vec![10]]];
    assert_eq!(found, [path, alone(5), alone(8), alone(9)]);
}

/// With and without a baseline, which is the first machine.
#[test]
fn each_gives_what_it_gives_alone() {
    let (header, stream) = quickstart();
    let machines = some();
    let cut = Cut { pixels: 16, before: 2, own: 2, behind: 1 };
    let plan = Plan::new(0.03, cut, 0);
    let sampled = |machines: &[&MachineSpec], baseline, target: &str| {
        let goal = Goal { target: target.parse().unwrap(), most: 0.5 };
        let found = sample_until((Sampled::Event, &header), machines, baseline, &plan, goal, &stream).unwrap();
        found.into_iter().map(Result::unwrap).collect::<Vec<_>>()
    };
    let (known, _) = sampled(&[&machines[0]], None, "0.3").remove(0);
    for (baseline, target) in [(None, "0.3"), (Some((&machines[0], &known)), "0.2")] {
        // One machine shares all tags with the baseline, one those of the L1s, three those of the path, of which one
        // separates. The others share none.
        let others: Vec<&MachineSpec> = [1, 3, 5, 6, 7, 8, 10].map(|at| &machines[at]).into();
        let together = sampled(&others, baseline, target);
        for (machine, together) in others.into_iter().zip(together) {
            assert!(together == sampled(&[machine], baseline, target)[0]);
            let change = together.0.residuals.unwrap().change;
            assert_eq!(change.is_some(), baseline.is_some());
        }
    }
}

/// The distribution of machines over threads, and what they share there, varies.
#[test]
fn machines_together_do_not_depend_on_the_number_of_threads() {
    let (header, stream) = quickstart();
    let machines = some();
    let cut = Cut { pixels: 16, before: 2, own: 2, behind: 1 };
    let by = |threads| {
        let sampler = Sampler { threads, ..Sampler::new(Sampled::Event, &header) };
        let members: Vec<_> =
            machines.iter().map(|machine| Member { machine, plan: Plan::new(0.03, cut, 0) }).collect();
        let passes = sampler.pass(&members, 2, &mut items(stream.clone())).unwrap();
        let of = |(machine, pass): (_, Result<Pass, _>)| Findings::of(&sampler, machine, &cut, pass.unwrap());
        machines.iter().zip(passes).map(of).collect::<Vec<_>>()
    };
    let one = by(1);
    assert!(by(3) == one && by(16) == one);
}

/// A single shadow-cache unit that holds rays up needs fewer rays in flight, so its machine separates.
#[test]
fn who_asks_for_fewer_rays_in_flight_parts() {
    let (header, stream) = quickstart();
    let machines = some();
    let plan = Plan::new(0.03, Cut { pixels: 16, before: 2, own: 2, behind: 1 }, 0);
    let parted = |of: [usize; 2]| {
        let on_lane = |at: usize| {
            let windows = Windows::new(&machines[at], &header, plan.clone(), 0);
            (&machines[at], OnLane { index: at, windows, cached: JobCache::default() })
        };
        let mut lanes = lanes(&header, of.into_iter().map(on_lane), 1);
        let mut cutter = Cutter::new(&header, &machines[0], &plan, 0);
        assert_eq!(lanes.len(), 1);
        for portion in stream.iter().flat_map(|item| cutter.add(item).unwrap()) {
            let new: Vec<Lane> = lanes.iter_mut().flat_map(Lane::split_off).collect();
            lanes.extend(new);
            lanes.iter_mut().for_each(|lane| drop(lane.add(&portion)));
        }
        lanes.len()
    };
    assert_eq!([parted([0, 6]), parted([0, 10]), parted([0, 7])], [1, 1, 2]);
}
