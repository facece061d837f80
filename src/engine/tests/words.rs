//! Effects of placement, layout, register and end-of-frame update on the accesses of shadow-cache units, in exact
//! numbers.

use super::*;
use crate::machine::shadow_cache::{FrameEnd, Place};
use crate::machine::stores::StoreLayout;

fn read(index: u32) -> Step {
    Step::Read { store: Store::ModeWord, index }
}

fn or(index: u32) -> Step {
    Step::Update { store: Store::ModeWord, index }
}

fn count(index: u32) -> Step {
    Step::Update { store: Store::PixelCounter, index }
}

/// One pixel after another, each with the given steps.
fn pixels(steps: impl IntoIterator<Item = Vec<Step>>) -> Vec<SyntheticRay> {
    steps.into_iter().map(|steps| SyntheticRay::primary(vec![]).with_policy(steps)).collect()
}

/// A machine with one ray in flight: rays are strictly sequential.
fn in_order() -> MachineSpec {
    let mut machine = MachineSpec::default();
    machine.dispatcher.rays = num(1);
    machine
}

/// The tally of both engines for one frame.
fn tally(machine: &MachineSpec, rays: &[SyntheticRay], end: &[Step]) -> Tally {
    let stream = frame(FrameInfo::default(), rays, end, 64);
    agreement::agree(machine, &header(), &stream).unwrap_or_else(|why| panic!("{why}")).0
}

fn accesses(tally: &Tally, kind: Kind, class: TrafficClass) -> u64 {
    tally.units[kind as usize].iter().map(|unit| unit.cache[class as usize].accesses).sum()
}

#[test]
fn a_register_merges_runs_of_one_primitive() {
    let mut machine = in_order();
    machine.shadow_cache.register = num(2);
    // Ten pixels of primitive 3, then ten of primitive 4: the register holds the word and counters of one primitive.
    let rays = pixels((0..20).map(|pixel| vec![read(3 + pixel / 10), count(3 + pixel / 10), or(3 + pixel / 10)]));
    let tally = tally(&machine, &rays, &[]);
    assert_eq!((tally.stores.merged_reads, tally.stores.merged_writes), (18, 36));
    // A read and an update of each primitive; the updates of the second wait until the end of the frame.
    assert_eq!(accesses(&tally, Kind::ShadowCache, TrafficClass::ModeWord), 4);
    assert_eq!(accesses(&tally, Kind::ShadowCache, TrafficClass::PixelCounter), 2);
}

#[test]
fn a_displaced_update_is_performed_by_the_ray_that_displaces_it() {
    let mut machine = in_order();
    machine.shadow_cache.register = num(1);
    let tally = tally(&machine, &pixels([vec![or(1)], vec![or(2)], vec![or(1)], vec![or(1)]]), &[]);
    assert_eq!(tally.stores.merged_writes, 1);
    assert_eq!(accesses(&tally, Kind::ShadowCache, TrafficClass::ModeWord), 3);
}

#[test]
fn past_the_l1_only_the_entry_moves_and_updates_need_no_data() {
    let mut machine = in_order();
    machine.shadow_cache.place = Place::L2;
    let tally = tally(&machine, &pixels([vec![read(0), or(0), count(0)]]), &[or(0)]);
    let [words, counters] = [TrafficClass::ModeWord, TrafficClass::PixelCounter].map(|class| class as usize);
    let unit = &tally.units[Kind::ShadowCache as usize][0];
    // The ray's read, and the read of the end-of-frame update, which sets modes.
    assert_eq!((unit.bypassed[words].count, unit.bypassed[words].bytes.0), (2, 8));
    assert_eq!((unit.written_through[words].count, unit.written_through[words].bytes.0), (2, 8));
    assert_eq!((unit.bypassed[counters].count, unit.written_through[counters].bytes.0), (0, 8));
    assert_eq!(accesses(&tally, Kind::ShadowCache, TrafficClass::ModeWord), 0);
}

#[test]
fn by_the_triangles_l1_the_access_is_made_there() {
    let mut machine = in_order();
    machine.shadow_cache.place = Place::Triangle;
    // Words 0 and 16 lie in lines of different parity: each of the two intersection units gets one.
    let tally = tally(&machine, &pixels([vec![read(0)], vec![read(16)]]), &[]);
    let class = TrafficClass::ModeWord as usize;
    assert_eq!(
        tally.units[Kind::Intersection as usize].iter().map(|unit| unit.cache[class].accesses).collect::<Vec<_>>(),
        [1, 1]
    );
    assert_eq!(accesses(&tally, Kind::ShadowCache, TrafficClass::ModeWord), 0);
    assert_eq!(tally.units[Kind::ShadowCache as usize][0].causes[Cause::Busy as usize], 2);
}

#[test]
fn words_that_are_free_cost_no_time() {
    let mut machine = MachineSpec::default();
    let rays: Vec<_> = (0..50).map(|_| SyntheticRay::primary(nodes([0, 1, 2]))).collect();
    let with_words: Vec<_> =
        rays.iter().map(|ray| ray.clone().with_policy(vec![read(5), count(5), or(5), or(9)])).collect();
    machine.shadow_cache.place = Place::Free;
    let (plain, free) = (tally(&machine, &rays, &[]), tally(&machine, &with_words, &[or(5), count(5)]));
    assert_eq!(Tally { stores: plain.stores, ..free }, plain);
}

#[test]
fn a_sweep_sets_every_static_primitive_once() {
    let mut machine = MachineSpec::default();
    machine.shadow_cache.frame_end = FrameEnd::Sweep;
    let statics = u64::from(header().static_primitives);
    let end = [count(5), or(5), or(4000)];
    let swept = tally(&machine, &[], &end);
    assert_eq!((swept.stores.covered_writes, swept.stores.added_writes), (2, 2 * statics));
    // Word 4000 belongs to a dynamic primitive.
    assert_eq!(accesses(&swept, Kind::ShadowCache, TrafficClass::ModeWord), statics + 1);
    machine.shadow_cache.layout = StoreLayout::Tagged;
    let swept = tally(&machine, &[], &end);
    assert_eq!((swept.stores.covered_writes, swept.stores.added_writes), (2, statics));
}

#[test]
fn the_first_touch_sets_what_the_frames_end_left() {
    let mut machine = in_order();
    machine.shadow_cache.frame_end = FrameEnd::Epoch;
    let rays = pixels([vec![read(7), count(7)], vec![read(7)], vec![or(4000)]]);
    let work = tally(&machine, &rays, &[count(7), or(7)]).stores;
    assert_eq!((work.raised_reads, work.added_writes, work.deferred_writes), (1, 1, 2));
    machine.shadow_cache.layout = StoreLayout::Tagged;
    let lazy = tally(&machine, &rays, &[count(7), or(7)]);
    assert_eq!((lazy.stores.raised_reads, lazy.stores.added_writes, lazy.stores.deferred_writes), (1, 0, 2));
    // The read that sets modes, the count, the second read, the OR of a dynamic primitive's word.
    assert_eq!(lazy.units[Kind::ShadowCache as usize][0].causes[Cause::Busy as usize], 4);
}

#[test]
fn units_share_the_work_by_lines() {
    let mut machine = MachineSpec::default();
    let rays = pixels((0..400).map(|pixel| vec![read(pixel), or(pixel)]));
    let one = tally(&machine, &rays, &[]);
    machine.shadow_cache.count = num(4);
    let four = tally(&machine, &rays, &[]);
    let busy = |tally: &Tally| {
        tally.units[Kind::ShadowCache as usize].iter().map(|unit| unit.causes[Cause::Busy as usize]).collect::<Vec<_>>()
    };
    assert_eq!(busy(&one), [800]);
    // 400 words are 25 lines of 16.
    assert_eq!(busy(&four), [7 * 32, 6 * 32, 6 * 32, 6 * 32]);
}

#[test]
fn lights_that_leave_no_room_for_the_tag_are_refused() {
    let mut machine = MachineSpec::default();
    machine.shadow_cache.frame_end = FrameEnd::Epoch;
    let header = Header { lights: 15, ..header() };
    let error = run(&machine, Level::Event, &header, &one_frame(&[])).unwrap_err().to_string();
    assert_eq!(
        error,
        "`shadow_cache.frame_end` is Epoch, which needs 2 bits beside the modes of the stream's 15 lights, and these fill \
         1 word(s) of 32 bits: `List`, `Sweep`, or `layout: Tagged` is allowed"
    );
    machine.shadow_cache.layout = StoreLayout::Tagged;
    assert!(run(&machine, Level::Event, &header, &one_frame(&[])).is_ok());
}
