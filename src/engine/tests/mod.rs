pub(crate) mod agreement;
mod allocation;
mod anomalies;
pub(crate) mod frames;
mod ideal;
mod least;
mod levels;
mod marks;
mod profile_words;
pub(crate) mod random;
pub(crate) mod recorded;
mod refusals;
pub(crate) mod synthetic;
mod traffic;
mod word_traffic;
mod words;

use self::synthetic::{STATIC, SyntheticRay, bvh_like, frame, header, nodes, triangle};
use super::bound::Bound;
use super::check;
use super::contract::Engine;
use super::cycle::Cycle;
use super::event::Event;
use super::profile::Profile;
use super::tally::{QueueKind, Tally, UnitTally};
use super::whole::{replay, whole};
use super::{Level, RunError};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::writes::WritePolicy;
use crate::memory::bank::BankedSpec;
use crate::memory::cache::Release;
use crate::memory::l2::{HomeSpec, L2Spec};
use crate::quantity::ListId;
use crate::ranged::{PowerOfTwo, PowerOfTwoSize, Size, Within};
use crate::replay::OnePass;
use crate::stats::{Cause, MachineStats, TrafficClass};
use crate::stream::{Decision, FrameInfo, Header, Item, Step, Stop, Store, StreamError};

pub(crate) fn num<const LO: u64, const HI: u64>(value: u64) -> Within<LO, HI> {
    Within::new(value).unwrap()
}

fn size<const LO: u64, const HI: u64>(value: u64) -> Size<LO, HI> {
    Size::new(value).unwrap()
}

fn pow_size<const LO: u64, const HI: u64>(value: u64) -> PowerOfTwoSize<LO, HI> {
    PowerOfTwoSize::new(value).unwrap()
}

fn pow<const LO: u64, const HI: u64>(value: u64) -> PowerOfTwo<LO, HI> {
    PowerOfTwo::new(value).unwrap()
}

pub(crate) fn items(items: Vec<Item>) -> impl Iterator<Item = Result<Item, StreamError>> {
    items.into_iter().map(Ok)
}

/// Replays `stream` at a fidelity level.
fn run(machine: &MachineSpec, level: Level, header: &Header, stream: &[Item]) -> Result<MachineStats, RunError> {
    crate::replay::Replay::new(machine, header)?.fidelity(OnePass::Whole(level)).run(items(stream.to_vec()))
}

fn replayed(machine: &MachineSpec, stream: Vec<Item>) -> MachineStats {
    run(machine, Level::Event, &header(), &stream).unwrap_or_else(|error| panic!("{error}"))
}

fn one_frame(rays: &[SyntheticRay]) -> Vec<Item> {
    frame(FrameInfo::default(), rays, &[], 64)
}

/// The machine with another line size and the same number of lines in a DRAM row.
fn with_line(mut machine: MachineSpec, line: u64) -> MachineSpec {
    let row = &mut machine.dram.part.row_bytes;
    *row = pow_size(row.get() / machine.line_bytes.get() * line);
    machine.line_bytes = pow_size(line);
    machine
}

/// The default machine with a DRAM of the same clock: all DRAM times are whole cycles.
fn in_step() -> MachineSpec {
    let mut machine = MachineSpec::default();
    machine.dram.part.clock_mhz = num(machine.clock_mhz.get());
    machine
}

/// Cycles from a miss in an L1 to its fill, in an idle machine whose DRAM has the machine's clock.
fn miss_latency(machine: &MachineSpec) -> u64 {
    let part = &machine.dram.part;
    let bursts = part.bursts(machine.line_bytes.get());
    let line = (bursts - 1) * part.timing.ccd_l.get() + part.burst_clocks.get();
    let dram = part.timing.rcd.get() + part.timing.cl.get() + line;
    // To the L2, to the DRAM, back to the L2, back to the L1: a cycle each.
    4 + dram + machine.l2.caches()[0].1.latency.get()
}

/// Cycles before the first ray is at its unit, and from its retirement to the end of the run: through both FIFOs, to
/// the end-of-frame update, and the last cycle itself.
fn frame_latency(machine: &MachineSpec) -> u64 {
    machine.dispatcher.latency.get() + 4
}

#[test]
fn one_ray_with_one_node_takes_the_sum_of_all_latencies() {
    let machine = in_step();
    let stats = replayed(&machine, one_frame(&[SyntheticRay::primary(nodes([0]))]));
    let expected = frame_latency(&machine) + miss_latency(&machine) + machine.traversal.latency.get();
    assert_eq!(stats.cycles.0, expected);
    assert_eq!((stats.rays, stats.dram.reads, stats.dram.row_misses), (1, 1, 1));
}

#[test]
fn a_hit_of_a_primary_ray_passes_twice_and_divides() {
    let machine = in_step();
    let unit = machine.intersection.latency.get();
    // Slot 0: plane and edges share a line of 64 bytes, so the second fetch hits.
    let both = miss_latency(&machine) + unit + machine.intersection.cache.latency.get() + unit;
    let (there_and_back, to_division) = (2, 1);
    for (stop, test) in [
        (Stop::Plane, miss_latency(&machine) + unit),
        (Stop::Edges, both),
        (Stop::Hit, both + to_division + machine.division.latency.get()),
    ] {
        let stats = replayed(&machine, one_frame(&[SyntheticRay::primary(vec![triangle(0, stop)])]));
        assert_eq!(stats.cycles.0, frame_latency(&machine) + there_and_back + test, "{stop:?}");
    }
}

/// A leaf of a kd-tree: list entries from `first` on, each with a triangle that is missed.
fn leaf(first: u32, count: u32) -> Vec<Step> {
    let entry = |index| [Step::List(ListId(index)), triangle(index, Stop::Plane)];
    (first..first + count).flat_map(entry).collect()
}

#[test]
fn a_leaf_goes_between_list_and_intersection_units_without_traversal() {
    let machine = in_step();
    let list = machine.list.latency.get();
    let test = machine.intersection.latency.get();
    let hit = machine.list.cache.latency.get() + machine.intersection.cache.latency.get();
    // Both entries share a line; both triangles' planes share a line in another bank of the DRAM.
    let first = miss_latency(&machine) + list + miss_latency(&machine) + test;
    let second = hit + list + test;
    // To the list, intersection, list, intersection and traversal unit.
    let ways = 5;
    let rays = [SyntheticRay::primary(leaf(32, 2))];
    let tally = agreement::agree(&machine, &header(), &one_frame(&rays)).unwrap().0;
    assert_eq!(tally.cycles, frame_latency(&machine) + ways + first + second);
    assert_eq!(tally.operations_by_kind(), [0, 2, 2, 0]);
}

#[test]
fn a_slow_division_unit_stops_those_before_it() {
    let mut machine = in_step();
    machine.intersection.count = num(2);
    machine.division.interval = num(18);
    machine.division.queue = num(1);
    let rays: Vec<_> = (0..200).map(|_| SyntheticRay::primary(vec![triangle(0, Stop::Hit)])).collect();
    let tally = agreement::agree(&machine, &header(), &one_frame(&rays)).unwrap().0;
    let cycles = |causes: &[u64], cause: Cause| causes[cause as usize];
    assert_eq!(cycles(&tally.divisions[0], Cause::Busy), 200 * 18);
    let begin_and_end = frame_latency(&machine) + miss_latency(&machine) + 6 * 18;
    assert!(tally.cycles - 200 * 18 < begin_and_end, "{}", tally.cycles);
    let blocked = |units: &[UnitTally]| units.iter().map(|unit| cycles(&unit.causes, Cause::Blocked)).sum::<u64>();
    assert!(blocked(&tally.units[Kind::Intersection as usize]) > 3 * 200 * 18 / 2);
    assert!(blocked(&tally.units[Kind::Traversal as usize]) > 200 * 18 / 2);
}

#[test]
fn rays_of_a_row_leave_it_one_a_cycle_and_nobody_accesses_meanwhile() {
    let mut machine = in_step();
    machine.traversal.count = num(1);
    machine.dispatcher.per_cycle = num(4);
    let rays: Vec<_> = (0..4).map(|_| SyntheticRay::primary(nodes([0]))).collect();
    let [together, one_by_one] = [Release::Together, Release::OneByOne].map(|release| {
        machine.traversal.cache.release = release;
        agreement::agree(&machine, &header(), &one_frame(&rays)).unwrap().0.cycles
    });
    // In both cases the four operations begin one after another. `OneByOne` releases the first ray in step 6, after
    // step 5 begins operations.
    assert_eq!(one_by_one, together + 1);
}

#[test]
fn cores_share_the_rays_and_have_an_l2_each() {
    let mut machine = in_step();
    (machine.traversal.count, machine.dispatcher.rays) = (num(1), num(20));
    let rays: Vec<_> = (0..400).map(|_| SyntheticRay::primary(nodes(vec![0; 50]))).collect();
    let stream = one_frame(&rays);
    let [one, four] = [1, 4].map(|cores| {
        machine.cores = num(cores);
        agreement::agree(&machine, &header(), &stream).unwrap().0
    });
    let busy: Vec<_> =
        four.units[Kind::Traversal as usize].iter().map(|unit| unit.causes[Cause::Busy as usize]).collect();
    assert_eq!((busy, one.operations_by_kind()[0]), (vec![5000; 4], 20_000));
    assert!((3.8..4.0).contains(&(one.cycles as f64 / four.cycles as f64)), "{} {}", one.cycles, four.cycles);
    // Each core fetches the node for its own L2.
    assert_eq!((one.commands().reads, four.commands().reads), (1, 4));
}

#[test]
fn a_skipped_ray_costs_one_operation_and_no_traversal() {
    let machine = in_step();
    let primary = SyntheticRay::primary(nodes([0]));
    let alone = replayed(&machine, one_frame(std::slice::from_ref(&primary)));
    let stats = replayed(&machine, one_frame(&[primary, SyntheticRay::shadow(1, Decision::Skip, Vec::new())]));
    // Through the out FIFO, through the in FIFO, to the unit; shading is added below.
    let ways = 3;
    let child = machine.dispatcher.shading_cycles.get() + ways + machine.shadow_cache.latency.get();
    assert_eq!(stats.cycles.0, alone.cycles.0 + child);
    assert_eq!((stats.rays, stats.bytes["l1_traversal"][&TrafficClass::Node].0), (1, 64));
    assert_eq!(stats.units["shadow_cache"][&Cause::Busy], 1);
}

#[test]
fn children_wait_for_the_policy_of_their_parent() {
    let machine = in_step();
    let primary = SyntheticRay::primary(nodes([0]));
    let shadow = SyntheticRay::shadow(1, Decision::Trace, nodes([0]));
    let plain = replayed(&machine, one_frame(&[primary.clone(), shadow.clone()]));
    // Word 32 lies in a different DRAM bank from node 0.
    let read = Step::Read { store: Store::ModeWord, index: 32 };
    let stats = replayed(&machine, one_frame(&[primary.with_policy(vec![read]), shadow]));
    let policy = 1 + miss_latency(&machine) + machine.shadow_cache.latency.get();
    assert_eq!(stats.cycles.0, plain.cycles.0 + policy);
}

#[test]
fn a_saturated_unit_begins_one_operation_a_cycle() {
    let mut machine = in_step();
    machine.traversal.count = num(1);
    let rays: Vec<_> = (0..200).map(|_| SyntheticRay::primary(nodes(vec![0; 50]))).collect();
    let stats = replayed(&machine, one_frame(&rays));
    let busy = stats.units["traversal"][&Cause::Busy];
    assert_eq!(busy, 200 * 50);
    let idle = stats.cycles.0 - busy;
    // Rays that miss together start together: the unit is idle at the beginning and while the last rays end.
    let (begin, end) = (frame_latency(&machine) + miss_latency(&machine), 9 * 50);
    assert!(idle < begin + end, "idle for {idle} cycles");
}

#[test]
fn misses_to_one_line_are_merged() {
    let mut machine = MachineSpec::default();
    machine.traversal.count = num(1);
    machine.dispatcher.per_cycle = num(4);
    let rays: Vec<_> = (0..4).map(|_| SyntheticRay::primary(nodes([7]))).collect();
    let stats = replayed(&machine, one_frame(&rays));
    let counts = stats.caches["l1_traversal"][&TrafficClass::Node];
    assert_eq!((counts.misses, counts.mshr_hits, counts.hits), (1, 3, 0));
    assert_eq!(stats.dram.reads, 1);
}

#[test]
fn a_node_over_two_lines_needs_both() {
    let machine = with_line(MachineSpec::default(), 32);
    let stats = replayed(&machine, one_frame(&[SyntheticRay::primary(nodes([0]))]));
    assert_eq!(stats.caches["l1_traversal"][&TrafficClass::Node].misses, 2);
    assert_eq!(stats.bytes["l1_traversal"][&TrafficClass::Node].0, 64);
}

/// A split L2 counts each class in its own cache, and answers with the same timing as a unified L2.
#[test]
fn classes_go_to_their_homes() {
    let mut machine = in_step();
    let home = |classes: &[TrafficClass]| HomeSpec { classes: classes.to_vec(), cache: BankedSpec::DEFAULT };
    let (nodes_alone, others) = TrafficClass::ALL[..TrafficClass::CACHED].split_at(1);
    machine.l2 = L2Spec::Split([("node", home(nodes_alone)), ("rest", home(others))].into_iter().collect());
    let mut path = nodes([0]);
    path.push(triangle(0, Stop::Plane));
    let stream = one_frame(&[SyntheticRay::primary(path)]);
    let split = replayed(&machine, stream.clone());
    assert_eq!(split.caches["l2_node"].keys().collect::<Vec<_>>(), [&TrafficClass::Node]);
    assert_eq!(split.caches["l2_rest"].keys().collect::<Vec<_>>(), [&TrafficClass::Triangle]);
    machine.l2 = L2Spec::Unified(BankedSpec::DEFAULT);
    assert_eq!(replayed(&machine, stream).cycles, split.cycles);
}

#[test]
fn dynamic_lines_do_not_outlive_their_frame() {
    let machine = MachineSpec::default();
    let info = FrameInfo { number: 0, dynamic_nodes: 4, ..FrameInfo::default() };
    let rays = [SyntheticRay::primary(nodes([0, STATIC + 1]))];
    let mut stream = frame(info, &rays, &[], 1);
    stream.extend(frame(FrameInfo { number: 1, ..info }, &rays, &[], 1));
    let stats = replayed(&machine, stream);
    assert_eq!(stats.dram.reads, 3, "the static node once, the dynamic one in each frame");
}

#[test]
fn a_frames_end_is_done_before_the_next_frame() {
    let machine = MachineSpec::default();
    let sweep: Vec<_> = (0..100).map(|index| Step::Update { store: Store::ModeWord, index }).collect();
    let mut stream = frame(FrameInfo::default(), &[], &sweep, 1);
    stream.extend(frame(FrameInfo::default(), &[], &sweep, 1));
    let stats = replayed(&machine, stream);
    assert_eq!(stats.units["shadow_cache"][&Cause::Busy], 200);
    assert_eq!(stats.bytes["l1_shadow_cache"][&TrafficClass::ModeWord].0, 800);
    assert_eq!(stats.dram.reads, 7, "400 bytes, kept over the frames");
}

#[test]
fn writes_go_through_or_back() {
    let mut machine = MachineSpec::default();
    let end: Vec<_> = (0..16).map(|index| Step::Update { store: Store::ModeWord, index }).collect();
    let stream = frame(FrameInfo::default(), &[], &end, 1);
    let back = replayed(&machine, stream.clone());
    machine.shadow_cache.writes = WritePolicy::Through;
    let through = replayed(&machine, stream);
    assert_eq!(back.bytes["l2"][&TrafficClass::ModeWord].0, 64);
    assert_eq!(through.bytes["l2"][&TrafficClass::ModeWord].0, 64 + 16 * 4);
}
