//! Rules H: the host's own traffic, in exact numbers, in both engines.

use super::*;
use crate::machine::traffic::{Build, RayBuffer, TrafficSpec};
use crate::machine::word_traffic::Decide;
use crate::memory::dram::spec::Model;

/// The tally of both engines.
fn tally(machine: &MachineSpec, stream: &[Item]) -> Tally {
    agreement::agree(machine, &header(), stream).unwrap_or_else(|why| panic!("{why}")).0
}

/// The default machine with rays in the DRAM.
fn rays_in_dram() -> MachineSpec {
    let traffic = TrafficSpec { rays: RayBuffer::Dram, ..TrafficSpec::default() };
    MachineSpec { traffic, ..MachineSpec::default() }
}

/// Lines of 64 bytes that the DRAM moved, per class.
fn lines<const N: usize>(tally: &Tally, classes: [TrafficClass; N]) -> [u64; N] {
    classes.map(|class| tally.channels.iter().map(|channel| channel.moved[class as usize].0 / 64).sum())
}

/// H2, H3.
#[test]
fn elements_share_lines_and_have_classes_of_their_own() {
    use TrafficClass::{FrameBuffer, Ray, Texture};
    let mut machine = rays_in_dram();
    (machine.traffic.pixel_bytes, machine.traffic.texture_bytes) = (size(4), size(16));
    let (hit, miss) = (triangle(0, Stop::Hit), triangle(0, Stop::Plane));
    let shadow = SyntheticRay::shadow(1, Decision::Trace, vec![hit]);
    let group = [SyntheticRay::primary(vec![hit]), shadow, SyntheticRay::primary(vec![miss])];
    // 12 rays of 32 bytes and hits of 16; 8 pixels of 4 bytes; 4 hits of primary rays with texels of 16 bytes.
    let few = tally(&machine, &one_frame(&[group.clone(), group.clone(), group.clone(), group.clone()].concat()));
    assert_eq!(lines(&few, [Ray, FrameBuffer, Texture]), [6 + 3, 1, 1]);
    assert_eq!((few.port.reads[Ray as usize], few.port.writes[Ray as usize]), (6, 3));
    // One more group begins new lines in each array except the frame buffer.
    let more = tally(&machine, &one_frame(&vec![group; 5].concat()));
    assert_eq!(lines(&more, [Ray, FrameBuffer, Texture]), [8 + 4, 1, 2]);
}

/// H2: a ray that the host answers is neither read nor written.
#[test]
fn answered_rays_move_nothing() {
    let mut machine = rays_in_dram();
    (machine.traffic.ray_bytes, machine.traffic.hit_bytes) = (size(64), size(64));
    let skipped = SyntheticRay::shadow(1, Decision::Skip, Vec::new());
    let stream = one_frame(&[SyntheticRay::primary(nodes([0])), skipped]);
    let moved = |decide| {
        let mut machine = machine.clone();
        machine.shadow_cache.decide = decide;
        lines(&tally(&machine, &stream), [TrafficClass::Ray])
    };
    assert_eq!([moved(Decide::Unit), moved(Decide::Hit)], [[4], [2]]);
}

/// H4, H5, H8: the port puts one line per cycle into a channel that never refuses. Ten rays have 64 lines each, with
/// three lines of hits between them. With `queue: 1` a ray is handed over only to an empty port. With a longer queue
/// the port still has lines, so that the eight hand-overs between cost no cycle.
#[test]
fn a_full_port_holds_rays_back() {
    let mut machine = rays_in_dram();
    machine.dram.model = Model::Flat { latency: num(1), bytes_per_cycle: None };
    (machine.traffic.ray_bytes, machine.traffic.queue) = (size(4096), num(1));
    let rays: Vec<_> = (0..10).map(|_| SyntheticRay::primary(nodes([0]))).collect();
    let held_back = |queue| {
        machine.traffic.queue = num(queue);
        tally(&machine, &one_frame(&rays)).dispatcher[Cause::Memory as usize]
    };
    assert_eq!([1, 64, 65, 1000].map(held_back), [9 * 64 + 3, 9 * 64 + 3 - 8 - 63, 9 * 64 + 3 - 8 - 64, 0]);
}

/// H6, H7: 100 triangles at a million per second take 50,000 cycles at 500 MHz.
#[test]
fn rays_and_the_frames_end_wait_for_the_builder() {
    let mut machine = MachineSpec::default();
    let info = FrameInfo { dynamic_slots: 100, dynamic_nodes: 4, ..FrameInfo::default() };
    let stream = frame(info, &[SyntheticRay::primary(nodes([0]))], &[], 1);
    let there = tally(&machine, &stream);
    machine.traffic.build_rate = num(1);
    let built = tally(&machine, &stream);
    // Without a builder the ray is handed over in cycle 1.
    assert!(built.cycles.abs_diff(there.cycles + 49_999) < 200, "{} {}", built.cycles, there.cycles);
    assert_eq!(built.dispatcher[Cause::Memory as usize], 49_999);
    assert_eq!(tally(&machine, &frame(info, &[], &[], 1)).cycles, 50_002);
    machine.traffic = TrafficSpec { build: Build::Written, ..TrafficSpec::default() };
    // Four nodes of 64 bytes and 100 records of 48 bytes, aligned to a line.
    assert_eq!(lines(&tally(&machine, &stream), [TrafficClass::Build]), [4 + 75]);
}

/// H7: the scene of a frame without rays is built before the next frame begins, by all levels.
#[test]
fn a_frame_without_rays_takes_as_long_as_its_building() {
    let mut machine = MachineSpec::default();
    machine.traffic.build_rate = num(1);
    let info = FrameInfo { dynamic_slots: 100, ..FrameInfo::default() };
    let (header, stream) = frames::numbered(&[frame(info, &[], &[], 1), frame(info, &[], &[], 1)].concat(), 0);
    let replayed = |fidelity| recorded::on(&machine, &header, fidelity, &stream);
    assert_eq!(replayed("Bound").cycles.0, 100_000);
    for level in ["Cycle", "Event", "Profile"] {
        let frames = replayed(level).frames.iter().map(|frame| frame.cycles.0).collect::<Vec<_>>();
        assert!(frames.len() == 2 && frames.iter().all(|cycles| cycles.abs_diff(50_000) < 10), "{level} {frames:?}");
    }
}

/// H6: building may take longer than the watchdog waits, and need not write anything.
#[test]
fn building_is_no_deadlock() {
    let mut machine = MachineSpec::default();
    machine.traffic.build_rate = num(1);
    let info = FrameInfo { dynamic_slots: 1000, ..FrameInfo::default() };
    for rays in [vec![], vec![SyntheticRay::primary(nodes([0]))]] {
        let cycles = tally(&machine, &frame(info, &rays, &[], 1)).cycles;
        assert!(cycles.abs_diff(500_000) < 300, "{cycles}");
    }
}

/// Traffic of an on-chip buffer is counted; nothing else changes.
#[test]
fn a_buffer_on_the_chip_counts_and_costs_nothing() {
    let stream = one_frame(&[SyntheticRay::primary(nodes([0])), SyntheticRay::primary(nodes([1]))]);
    let mut machine = MachineSpec::default();
    let free = replayed(&machine, stream.clone());
    machine.traffic.rays = RayBuffer::OnChip;
    let buffered = replayed(&machine, stream);
    assert_eq!(buffered.moved("ray_buffer").0, 2 * (32 + 16));
    assert_eq!((buffered.cycles, buffered.dram, free.moved("ray_buffer").0), (free.cycles, free.dram, 0));
}
