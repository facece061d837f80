//! Counts per frame, and warm-up frames.

use super::agreement::check_many;
use super::random::{machines, streams};
use super::synthetic::{bvh_like, frame, header};
use super::*;
use crate::stats::{Bounds, FrameStats};

/// The stream with frames numbered from 0, and its header with the first `warmup` frames as warm-up.
pub(crate) fn numbered(stream: &[Item], warmup: u32) -> (Header, Vec<Item>) {
    let mut frames = 0;
    let number = |item: &Item| match item {
        Item::Frame(info) => {
            frames += 1;
            Item::Frame(FrameInfo { number: frames - 1, ..*info })
        }
        other => other.clone(),
    };
    let stream = stream.iter().map(number).collect();
    (Header { frames: (0..frames).collect(), warmup: (0..warmup.min(frames)).collect(), ..header() }, stream)
}

fn on(machine: &MachineSpec, level: Level, header: &Header, stream: &[Item]) -> Result<MachineStats, String> {
    run(machine, level, header, stream).map_err(|error| error.to_string())
}

#[test]
fn both_engines_count_the_same_in_every_frame() {
    check_many(
        100,
        || (machines(), streams(), 0..2u32),
        |(machine, stream, warmup)| {
            let (header, stream) = numbered(&stream, warmup);
            let [event, cycle] = [Level::Event, Level::Cycle].map(|level| on(&machine, level, &header, &stream));
            if event != cycle {
                return Err(format!("Event {event:#?}\nCycle {cycle:#?}"));
            }
            Ok(())
        },
    );
}

/// Three frames that access the same lines; the first is a warm-up frame.
fn twice() -> (Header, Vec<Item>) {
    let rays = bvh_like(7, 200, 9, 1);
    let frames = [0, 1, 2].map(|number| frame(FrameInfo { number, ..FrameInfo::default() }, &rays, &[], 64));
    numbered(&frames.concat(), 1)
}

#[test]
fn warm_up_frames_are_told_and_left_out() {
    let machine = MachineSpec::default();
    let (header, stream) = twice();
    for level in [Level::Bound, Level::Profile, Level::Event, Level::Cycle] {
        let whole = on(&machine, level, &Header { warmup: Vec::new(), ..header.clone() }, &stream).unwrap();
        let warm = on(&machine, level, &header, &stream).unwrap();
        let sum = |of: &dyn Fn(&FrameStats) -> u64, stats: &MachineStats, all: bool| {
            stats.frames.iter().filter(|frame| all || !frame.warmup).map(of).sum::<u64>()
        };
        let warmups: Vec<_> = warm.frames.iter().map(|frame| (frame.frame, frame.warmup)).collect();
        assert_eq!(warmups, [(0, true), (1, false), (2, false)], "{level}");
        for figure in [
            &(|frame: &FrameStats| frame.cycles.0) as &dyn Fn(&FrameStats) -> u64,
            &|frame| frame.rays,
            &|frame| frame.bytes["dram"].0,
            &|frame| frame.bytes["l2"].0,
            &|frame| frame.dram.reads,
        ] {
            assert_eq!(sum(figure, &warm, true), sum(figure, &whole, true), "{level}");
        }
        assert_eq!(sum(&|frame| frame.cycles.0, &warm, false), warm.cycles.0, "{level}");
        assert_eq!(sum(&|frame| frame.bytes["dram"].0, &warm, false), warm.moved("dram").0, "{level}");
        assert_eq!(sum(&|frame| frame.rays, &warm, false), warm.rays, "{level}");
        // Lines that the first frame fetched are still in the caches.
        assert!(warm.frames[1].bytes["dram"] < warm.frames[0].bytes["dram"], "{level}");
        let Bounds { cycles, dram_bytes, .. } = warm.bounds.unwrap();
        assert!((cycles.least..=cycles.most).contains(&warm.cycles), "{level}");
        assert!((dram_bytes.least..=dram_bytes.most).contains(&warm.moved("dram")), "{level}");
    }
}

#[test]
fn energy_is_told_by_every_level_and_its_parts_sum_to_it() {
    let machine = MachineSpec::default();
    let (header, stream) = twice();
    for level in [Level::Bound, Level::Profile, Level::Event, Level::Cycle] {
        let stats = on(&machine, level, &header, &stream).unwrap();
        let energy = stats.energy.clone().unwrap();
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
        assert!(near(energy.by.values().sum(), energy.joules), "{level}");
        assert!(energy.low < energy.joules && energy.joules < energy.high, "{level}");
        assert!(energy.classes.values().sum::<f64>() < energy.joules, "{level}");
        let measured = stats.frames.iter().filter(|frame| !frame.warmup);
        let frames = measured.map(|frame| frame.energy.as_ref().unwrap());
        assert!(near(frames.clone().map(|energy| energy.joules).sum(), energy.joules), "{level}");
        assert!(near(frames.map(|energy| energy.high).sum(), energy.high), "{level}");
    }
}
