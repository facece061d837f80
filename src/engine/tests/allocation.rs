//! Accesses that do not allocate, and write-through, by traffic class.

use super::*;
use crate::memory::allocation::{Classes, NoAllocate};
use crate::stats::TrafficClass::{ModeWord, Node, PixelCounter};

fn only(class: TrafficClass) -> Classes {
    vec![class].into()
}

const NOTHING: Classes = NoAllocate::NONE.reads;

/// The default machine with a changed L2 and one context in its shadow-cache unit.
fn machine(l2: NoAllocate) -> MachineSpec {
    let mut machine = MachineSpec::default();
    machine.shadow_cache.contexts = num(1);
    machine.l2 = L2Spec::Unified(BankedSpec { no_allocate: l2, ..BankedSpec::DEFAULT });
    machine
}

/// Updates of the 16 words in a line.
fn updates() -> Vec<Item> {
    let end: Vec<_> = (0..16).map(|index| Step::Update { store: Store::ModeWord, index }).collect();
    frame(FrameInfo::default(), &[], &end, 1)
}

#[test]
fn a_class_that_allocates_nowhere_is_fetched_every_time() {
    let none = NoAllocate { reads: only(Node), writes: NOTHING };
    let stream = one_frame(&[SyntheticRay::primary(nodes([0; 10]))]);
    for (l1, l2, expected) in [
        (NoAllocate::NONE, NoAllocate::NONE, [1, 1]),
        (NoAllocate::NONE, none, [1, 1]),
        (none, NoAllocate::NONE, [10, 1]),
        (none, none, [10, 10]),
    ] {
        let mut machine = machine(l2);
        machine.traversal.cache.no_allocate = l1;
        let stats = replayed(&machine, stream.clone());
        assert_eq!([stats.caches["l1_traversal"][&Node].misses, stats.dram.reads], expected, "{l1:?} {l2:?}");
    }
}

#[test]
fn a_class_does_not_displace_those_that_allocate() {
    // The L1 holds two lines of a set: node 0 stays while other lines stream past it.
    let mut machine = MachineSpec::default();
    let cache = &mut machine.shadow_cache.cache;
    (cache.bytes, cache.ways) = (size(128), num(2));
    cache.no_allocate.reads = only(ModeWord);
    let read = |index| Step::Read { store: Store::ModeWord, index };
    let policy = [vec![Step::Node(crate::quantity::NodeId(0))], (0..10).map(|i| read(16 * i)).collect()].concat();
    let ray = SyntheticRay::primary(Vec::new()).with_policy([policy.clone(), policy].concat());
    let counts = &replayed(&machine, one_frame(&[ray])).caches["l1_shadow_cache"];
    assert_eq!((counts[&Node].misses, counts[&Node].hits), (1, 1));
    assert_eq!((counts[&ModeWord].misses, counts[&ModeWord].hits), (20, 0));
}

#[test]
fn a_write_that_does_not_allocate_goes_down_at_once() {
    let mut machine = machine(NoAllocate::NONE);
    machine.shadow_cache.cache.no_allocate.writes = only(ModeWord);
    let stats = replayed(&machine, updates());
    let l1 = stats.caches["l1_shadow_cache"][&ModeWord];
    assert_eq!((l1.hits, l1.misses, l1.write_backs), (0, 16, 16));
    assert_eq!((stats.moved("l2").0, stats.dram.reads), (32 * 64, 1));
    // With write-through instead of write-back, a write sends its bytes down; the line is still fetched.
    machine.shadow_cache.writes = WritePolicy::Through;
    let stats = replayed(&machine, updates());
    assert_eq!((stats.moved("l2").0, stats.dram.reads), (16 * (64 + 4), 1));
}

#[test]
fn writes_pass_an_l2_that_gives_them_no_place() {
    let unallocated = NoAllocate { reads: only(ModeWord), writes: only(ModeWord) };
    for (l2, passed, dram) in [
        (NoAllocate::NONE, 0, (1, 0)),
        // Reads allocate the line, so that writes hit.
        (NoAllocate { reads: NOTHING, writes: only(ModeWord) }, 0, (1, 0)),
        (unallocated, 16, (1, 16)),
    ] {
        let mut machine = machine(l2);
        machine.shadow_cache.writes = WritePolicy::Through;
        let stats = replayed(&machine, updates());
        assert_eq!(stats.caches["l2"][&ModeWord].passed_writes, passed, "{l2:?}");
        assert_eq!((stats.dram.reads, stats.dram.writes), dram, "{l2:?}");
    }
}

#[test]
fn classes_go_through_or_back_each_for_itself() {
    let mut machine = machine(NoAllocate::NONE);
    machine.shadow_cache.writes = WritePolicy::ThroughFor(only(ModeWord));
    let update = |index| [Store::ModeWord, Store::PixelCounter].map(|store| Step::Update { store, index });
    let end: Vec<_> = (0..8).flat_map(update).collect();
    let stats = replayed(&machine, frame(FrameInfo::default(), &[], &end, 1));
    assert_eq!(stats.bytes["l2"][&ModeWord].0, 64 + 8 * 4);
    assert_eq!(stats.bytes["l2"][&PixelCounter].0, 64);
}
