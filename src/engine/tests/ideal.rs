//! Ideal caches and flat DRAM, compared with closed forms.

use super::*;
use crate::memory::cache::CacheSpec;
use crate::memory::dram::spec::Model;
use crate::memory::tags::Contents;
use crate::stats::{Accuracy, LatencyCounts};

/// The machine `configs/machines/ideal.ron` with L1s of `latency` cycles.
fn ideal(latency: u64) -> MachineSpec {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/machines/ideal.ron");
    let mut machine: MachineSpec = crate::ron_file::read(&path).unwrap();
    let MachineSpec { traversal, list, intersection, shadow_cache, .. } = &mut machine;
    for cache in [&mut traversal.cache, &mut list.cache, &mut intersection.cache, &mut shadow_cache.cache] {
        cache.latency = num(latency);
    }
    machine
}

/// Compares all fidelity levels that run a whole stream; returns the statistics of `Event`.
fn on_all_rungs(machine: &MachineSpec, stream: &[Item]) -> MachineStats {
    let on = |rung| run(machine, rung, &header(), stream).unwrap_or_else(|error| panic!("{error}"));
    let [event, cycle, profile] = [Level::Event, Level::Cycle, Level::Profile].map(on);
    assert_eq!(event, cycle);
    let bound = on(Level::Bound);
    assert_eq!((bound.accuracy, bound.bounds), (Accuracy::Bounded, event.bounds));
    // `Profile` does not model L1 banks.
    let accesses = |stats: &MachineStats| {
        let classes = stats.caches["l1_traversal"].iter();
        classes.map(|(&class, cache)| (class, cache.counts)).collect::<Vec<_>>()
    };
    assert_eq!((event.rays, accesses(&event)), (profile.rays, accesses(&profile)));
    event
}

#[test]
fn a_ray_on_ideal_l1s_takes_hits_and_operations_alone() {
    for latency in [1, 5] {
        let machine = ideal(latency);
        let stats = on_all_rungs(&machine, &one_frame(&[SyntheticRay::primary(nodes(0..30))]));
        let expected = frame_latency(&machine) + 30 * (latency + machine.traversal.latency.get());
        assert_eq!(stats.cycles.0, expected);
        assert_eq!((stats.moved("l1_traversal").0, stats.moved("l2").0, stats.moved("dram").0), (30 * 64, 0, 0));
        // The bound includes everything except the hand-over and the report of the end.
        let bound = stats.bounds.unwrap().cycles.least.0;
        assert_eq!(expected - bound, frame_latency(&machine) - machine.dispatcher.latency.get());
    }
}

/// The lower bound of a ray's latency is exactly the latency of a ray that is alone.
#[test]
fn a_ray_alone_takes_its_least_latency() {
    for latency in [1, 5] {
        let machine = ideal(latency);
        let tests = [Stop::Plane, Stop::Edges, Stop::Hit].map(|stop| triangle(3, stop));
        let nodes = nodes(0..3);
        // The bound does not count the way to a list unit.
        let paths = [(nodes.clone(), 0), (tests.to_vec(), 0), ([&nodes[..], &tests].concat(), 0), (leaf(0, 4), 1)];
        for (path, more) in paths {
            let stats = on_all_rungs(&machine, &one_frame(&[SyntheticRay::primary(path.clone())]));
            let LatencyCounts { cycles, unloaded, most, .. } = stats.latency["primary"];
            assert_eq!((cycles, most), (unloaded + more, cycles), "{latency}: {path:?}");
        }
    }
}

/// Lines of 32 B: a node needs two accesses. With one port a unit gets a node every other cycle, with two every cycle.
#[test]
fn ports_limit_an_ideal_l1() {
    let rays: Vec<_> = (0..100).map(|ray| SyntheticRay::primary(nodes((0..50).map(|node| ray + node)))).collect();
    for (ports, cycles_a_node) in [(1, 2), (2, 1)] {
        let mut machine = ideal(3);
        machine.line_bytes = pow_size(32);
        machine.traversal.count = num(1);
        machine.traversal.cache.ports = num(ports);
        let stats = on_all_rungs(&machine, &one_frame(&rays));
        let least = 100 * 50 * cycles_a_node;
        let bound = stats.bounds.unwrap().cycles.least.0;
        assert!(least <= bound && bound <= stats.cycles.0, "{ports} ports: {bound}, {}", stats.cycles.0);
        // The last rays end one after another.
        assert!(stats.cycles.0 < least + 500, "{ports} ports: {} cycles", stats.cycles.0);
    }
}

#[test]
fn a_miss_to_an_ideal_l2_is_there_and_back() {
    let mut machine = ideal(1);
    machine.traversal.cache = CacheSpec::DEFAULT;
    let L2Spec::Unified(l2) = machine.l2 else { panic!("the machine's L2 is split") };
    let stats = on_all_rungs(&machine, &one_frame(&[SyntheticRay::primary(nodes([0]))]));
    // One cycle to the L2, one back.
    assert_eq!(stats.cycles.0, frame_latency(&machine) + 2 + l2.latency.get() + machine.traversal.latency.get());
    assert_eq!((stats.moved("l2").0, stats.moved("dram").0), (64, 0));
}

#[test]
fn a_miss_to_a_flat_dram_takes_the_transfer_and_the_latency() {
    for (bytes_per_cycle, transfer) in [(None, 0), (Some(16), 4), (Some(24), 3), (Some(200), 1)] {
        let mut machine = MachineSpec::default();
        machine.dram.model = Model::Flat { latency: num(70), bytes_per_cycle: bytes_per_cycle.map(size) };
        let stats = on_all_rungs(&machine, &one_frame(&[SyntheticRay::primary(nodes([0]))]));
        let l2 = machine.l2.caches()[0].1.latency.get();
        // To the L2, to the DRAM, back to the L2, back to the L1: a cycle each.
        let miss = 4 + transfer + 70 + l2;
        assert_eq!(stats.cycles.0, frame_latency(&machine) + miss + machine.traversal.latency.get());
        assert_eq!((stats.dram.reads, stats.dram.row_misses, stats.dram.refreshes), (1, 0, 0));
        assert_eq!(stats.dram_peak_bytes_per_cycle, bytes_per_cycle.map(|bytes| bytes as f64));
    }
}

/// With ideal caches at every level, no write goes down.
#[test]
fn writes_end_in_an_ideal_cache() {
    let end: Vec<_> = (0..500).map(|index| Step::Update { store: Store::ModeWord, index: 8 * index }).collect();
    let stream = frame(FrameInfo::default(), &[], &end, 1);
    let stats = on_all_rungs(&ideal(1), &stream);
    assert_eq!(stats.caches["l1_shadow_cache"][&TrafficClass::ModeWord].hits, 500);
    let mut machine = ideal(1);
    machine.shadow_cache.cache = CacheSpec { contents: Contents::Tags, ..MachineSpec::default().shadow_cache.cache };
    let stats = on_all_rungs(&machine, &stream);
    let l2 = stats.caches["l2"][&TrafficClass::ModeWord];
    assert!(l2.hits > 400 && l2.hits == l2.accesses, "{l2:?}");
    assert_eq!(stats.moved("dram").0, 0);
}

/// Bank conflicts in the traversal units' L1s: two rays access their nodes in one cycle, and a line of 64 B is a node.
fn bank_conflicts(stats: &MachineStats) -> u64 {
    stats.caches["l1_traversal"][&TrafficClass::Node].l1.unwrap().bank_conflicts
}

#[test]
fn accesses_of_a_cycle_to_one_bank_conflict() {
    for (banks, second, conflicts) in
        [(None, 0, 0), (Some(1), 1, 1), (Some(2), 0, 1), (Some(2), 1, 0), (Some(2), 2, 1), (Some(4), 2, 0)]
    {
        let mut machine = ideal(1);
        machine.dispatcher.per_cycle = num(2);
        machine.traversal.count = num(1);
        let cache = &mut machine.traversal.cache;
        (cache.ports, cache.banks) = (num(2), banks.map(pow));
        let rays = [0, second].map(|node| SyntheticRay::primary(nodes([node])));
        let stats = on_all_rungs(&machine, &one_frame(&rays));
        assert_eq!(bank_conflicts(&stats), conflicts, "{banks:?} {second}");
    }
}

/// A node has two lines: two banks hold one each, one bank holds both.
#[test]
fn banks_limit_ports() {
    let rays: Vec<_> = (0..100).map(|ray| SyntheticRay::primary(nodes((0..50).map(|node| ray + node)))).collect();
    for (banks, cycles_a_node) in [(1, 2), (2, 1)] {
        let mut machine = ideal(3);
        machine.line_bytes = pow_size(32);
        machine.traversal.count = num(1);
        (machine.traversal.cache.ports, machine.traversal.cache.banks) = (num(2), Some(pow(banks)));
        let stats = on_all_rungs(&machine, &one_frame(&rays));
        let least = 100 * 50 * cycles_a_node;
        assert!(least <= stats.cycles.0 && stats.cycles.0 < least + 500, "{banks} banks: {} cycles", stats.cycles.0);
        let conflicts = bank_conflicts(&stats);
        assert_eq!(conflicts == 0, banks == 2, "{conflicts}");
    }
}
