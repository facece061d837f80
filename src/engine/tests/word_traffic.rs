//! Effects of the options for silent updates, decisions, width, gathering and latched copies, in exact numbers.

use super::*;
use crate::machine::word_traffic::{Decide, LatchedCopy, SilentUpdates};
use crate::stream::Effect;

fn read(index: u32) -> Step {
    Step::Read { store: Store::ModeWord, index }
}

/// A shadow ray that visits a node and updates a word.
fn shadow(index: u32, effect: Effect, parent: u32) -> SyntheticRay {
    let ray = SyntheticRay::shadow(parent, Decision::Trace, nodes([0]));
    SyntheticRay { policy: vec![Step::pack_word_update(index, effect)], ..ray }
}

/// The tally of both engines for one frame.
fn tally(machine: &MachineSpec, rays: &[SyntheticRay]) -> Tally {
    agreement::agree(machine, &header(), &one_frame(rays)).unwrap_or_else(|why| panic!("{why}")).0
}

fn operations(tally: &Tally) -> u64 {
    tally.units[Kind::ShadowCache as usize].iter().map(|unit| unit.operations).sum()
}

/// A hit that reads word 3, and its shadow rays, whose updates have all effects.
fn hit() -> Vec<SyntheticRay> {
    let primary = SyntheticRay::primary(nodes([0])).with_policy(vec![read(3)]);
    let effects = [Effect::Changes, Effect::Repeats, Effect::Silent, Effect::Silent];
    let shadows = effects.into_iter().zip(1..).map(|(effect, parent)| shadow(3, effect, parent));
    [primary].into_iter().chain(shadows).collect()
}

#[test]
fn updates_that_change_nothing_are_dropped() {
    let dropped = |silent| {
        let mut machine = MachineSpec::default();
        machine.shadow_cache.silent = silent;
        let tally = tally(&machine, &hit());
        (tally.stores.dropped_writes, operations(&tally))
    };
    assert_eq!(dropped(SilentUpdates::Sent), (0, 5));
    assert_eq!(dropped(SilentUpdates::Latched), (2, 3));
    assert_eq!(dropped(SilentUpdates::Live), (3, 2));
}

#[test]
fn updates_of_one_hit_are_sent_once() {
    let gathered = |entries, rays: &[SyntheticRay]| {
        let mut machine = MachineSpec::default();
        machine.shadow_cache.gather = num(entries);
        let tally = tally(&machine, rays);
        (tally.stores.gathered_writes, operations(&tally))
    };
    assert_eq!(gathered(0, &hit()), (0, 5));
    assert_eq!(gathered(1, &hit()), (3, 2));
    // With two hits at a time, a single entry serves only the first.
    let both = [hit(), hit()].concat();
    assert_eq!(gathered(1, &both), (3, 7));
    assert_eq!(gathered(2, &both), (6, 4));
}

#[test]
fn a_ray_decided_with_its_hit_crosses_no_fifo() {
    let primary = SyntheticRay::primary(nodes([0])).with_policy(vec![read(3)]);
    let rays = [primary, SyntheticRay::shadow(1, Decision::Skip, Vec::new())];
    let by = |decide| {
        let mut machine = MachineSpec::default();
        machine.shadow_cache.decide = decide;
        let tally = tally(&machine, &rays);
        (tally.stores.answered_rays, operations(&tally), tally.queues[QueueKind::Dispatcher as usize][0].entries)
    };
    assert_eq!(by(Decide::Unit), (0, 2, 2));
    assert_eq!(by(Decide::Hit), (1, 1, 1));
}

#[test]
fn a_skipped_ray_with_steps_is_sent_without_an_operation_of_its_own() {
    let primary = SyntheticRay::primary(nodes([0]));
    let skipped = SyntheticRay::shadow(1, Decision::Skip, Vec::new()).with_policy(vec![read(3)]);
    let mut machine = MachineSpec::default();
    machine.shadow_cache.decide = Decide::Hit;
    let tally = tally(&machine, &[primary, skipped]);
    assert_eq!((tally.stores.answered_rays, operations(&tally)), (0, 1));
}

/// The register merges all updates at once: no operation begins, and only the intake limits the unit.
#[test]
fn cycles_lost_at_the_intake_are_not_starved() {
    let by = |width| {
        let mut machine = in_step();
        (machine.traversal.count, machine.traversal.rays) = (num(8), num(20));
        (machine.dispatcher.per_cycle, machine.dispatcher.rays) = (num(8), num(128));
        (machine.shadow_cache.register, machine.shadow_cache.width) = (num(4), num(width));
        (machine.dispatcher.in_fifo, machine.dispatcher.out_fifo) = (num(64), num(64));
        let rays: Vec<_> = (0..256)
            .map(|_| SyntheticRay {
                policy: vec![Step::pack_word_update(3, Effect::Silent)],
                ..SyntheticRay::primary(nodes([0]))
            })
            .collect();
        let tally = tally(&machine, &rays);
        let causes = tally.units[Kind::ShadowCache as usize][0].causes;
        (tally.cycles, causes[Cause::Intake as usize])
    };
    let (narrow, wide) = (by(1), by(8));
    assert!(narrow.1 > 100 && wide.1 < 10, "{narrow:?} {wide:?}");
    assert!(narrow.0 > wide.0 + 100, "{narrow:?} {wide:?}");
}

/// The cost of a second copy of the words: a read and an update of each learned word.
#[test]
fn learned_bits_in_a_buffer_are_folded_at_the_frames_end() {
    let folded = |latched| {
        let mut machine = MachineSpec::default();
        machine.shadow_cache.latched = latched;
        let tally = tally(&machine, &hit());
        (tally.stores.added_reads, tally.stores.added_writes, operations(&tally))
    };
    assert_eq!(folded(LatchedCopy::Free), (0, 0, 5));
    assert_eq!(folded(LatchedCopy::Wide), (0, 0, 5));
    assert_eq!(folded(LatchedCopy::Buffers), (1, 1, 7));
}

/// A unit that begins several operations at once is busy for fewer cycles, with the same work and energy.
#[test]
fn a_wider_unit_begins_as_many_operations() {
    let rays: Vec<_> = (0..32).flat_map(|_| hit()).collect();
    let by = |width, interval| {
        let mut machine = in_step();
        let unit = &mut machine.shadow_cache;
        (unit.width, unit.interval, unit.latency, unit.contexts) = (num(width), num(interval), num(8), num(32));
        let tally = tally(&machine, &rays);
        let busy = tally.units[Kind::ShadowCache as usize][0].causes[Cause::Busy as usize];
        let stats = replayed(&machine, one_frame(&rays));
        assert_eq!(stats.operations["shadow_cache"], operations(&tally));
        let energy = stats.energy.unwrap().by["shadow_cache"];
        let expected = machine.energy.shadow_cache.typical * 1e-12 * operations(&tally) as f64;
        assert!((energy / expected - 1.0).abs() < 1e-9);
        (operations(&tally), busy)
    };
    let steps = 32 * 5;
    assert_eq!((by(1, 1), by(1, 4)), ((steps, steps), (steps, 4 * steps)));
    for (width, interval) in [(2, 1), (4, 1), (4, 3)] {
        let (operations, busy) = by(width, interval);
        assert_eq!(operations, steps);
        assert!(busy < steps * interval, "width {width}, interval {interval}: {busy}");
    }
}
