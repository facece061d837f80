//! A reader of the format, and checks of the tracks against the frames of random machines.

use std::collections::BTreeMap;
use std::path::Path;

use super::*;
use crate::engine::tests::agreement::check_many;
use crate::engine::tests::frames::numbered;
use crate::engine::tests::random::{machines, streams};
use crate::engine::tests::synthetic::{bvh_like, frame};
use crate::replay::{Exact, Fidelity, Replay};
use crate::stats::{FrameStats, MachineStats};
use crate::stream::{FrameInfo, Item};

/// The value of a protobuf field.
enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

fn varint(bytes: &mut &[u8]) -> u64 {
    let mut value = 0;
    for shift in (0..).step_by(7) {
        let (byte, rest) = bytes.split_first().unwrap();
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            break;
        }
    }
    value
}

/// The fields of a message.
fn fields(mut bytes: &[u8]) -> Vec<(u64, Value<'_>)> {
    let mut found = Vec::new();
    while !bytes.is_empty() {
        let tag = varint(&mut bytes);
        let value = match tag & 7 {
            0 => Value::Number(varint(&mut bytes)),
            2 => {
                let length = varint(&mut bytes) as usize;
                let (value, rest) = bytes.split_at(length);
                bytes = rest;
                Value::Bytes(value)
            }
            kind => panic!("wire type {kind}"),
        };
        found.push((tag >> 3, value));
    }
    found
}

fn number(bytes: &[u8], field: u64) -> Option<u64> {
    fields(bytes).into_iter().find_map(|(own, value)| match value {
        Value::Number(number) if own == field => Some(number),
        _ => None,
    })
}

fn bytes(message: &[u8], field: u64) -> Option<&[u8]> {
    fields(message).into_iter().find_map(|(own, value)| match value {
        Value::Bytes(bytes) if own == field => Some(bytes),
        _ => None,
    })
}

fn text(message: &[u8], field: u64) -> String {
    String::from_utf8(bytes(message, field).unwrap().to_vec()).unwrap()
}

/// The content of a timeline.
#[derive(Debug, Default)]
struct Shown {
    /// Names of tracks and of their parents.
    tracks: BTreeMap<u64, (String, Option<u64>)>,
    /// Slices: track, name, begin, end.
    slices: Vec<(u64, String, u64, u64)>,
    /// Values of counters: track, time, value.
    counts: Vec<(u64, u64, u64)>,
}

/// Reads a trace as Perfetto does: one packet sequence, timestamps as differences, interned names.
fn read(trace: &[u8]) -> Shown {
    let (mut shown, mut names, mut now) = (Shown::default(), BTreeMap::new(), 0);
    let mut open: BTreeMap<u64, (String, u64)> = BTreeMap::new();
    for (field, packet) in fields(trace) {
        let Value::Bytes(packet) = packet else { panic!("a packet is a message") };
        assert_eq!((field, number(packet, 10)), (1, Some(1)), "a packet of the sequence");
        if let Some(track) = bytes(packet, 60) {
            let id = number(track, 1).unwrap();
            assert!(shown.tracks.insert(id, (text(track, 2), number(track, 5))).is_none(), "a track twice");
        }
        if let Some(name) = bytes(packet, 12).and_then(|interned| bytes(interned, 2)) {
            names.insert(number(name, 1).unwrap(), text(name, 2));
        }
        let Some(event) = bytes(packet, 11) else { continue };
        now += number(packet, 8).unwrap();
        let track = number(event, 11).unwrap();
        assert!(shown.tracks.contains_key(&track));
        match number(event, 9).unwrap() {
            1 => {
                let name = names[&number(event, 10).unwrap()].clone();
                assert!(open.insert(track, (name, now)).is_none(), "no slice lies in another");
            }
            2 => {
                let (name, begin) = open.remove(&track).unwrap();
                shown.slices.push((track, name, begin, now));
            }
            3 => {}
            4 => shown.counts.push((track, now, number(event, 30).unwrap())),
            kind => panic!("event type {kind}"),
        }
    }
    assert!(open.is_empty(), "all slices end");
    shown
}

impl Shown {
    /// The kind of a part: the name of its track without its index.
    fn kind(&self, track: u64) -> &str {
        self.tracks[&track].0.rsplit_once(' ').unwrap().0
    }

    /// Cycles of each kind of unit, by cause.
    fn units(&self) -> BTreeMap<String, BTreeMap<String, u64>> {
        let mut sums: BTreeMap<String, BTreeMap<String, u64>> = BTreeMap::new();
        for (track, name, begin, end) in self.slices.iter().filter(|slice| slice.1 != "row open") {
            *sums.entry(self.kind(*track).into()).or_default().entry(name.clone()).or_default() += end - begin;
        }
        sums
    }
}

/// The causes in a frame's statistics with nonzero cycles, by name.
fn causes(frame: &FrameStats) -> BTreeMap<String, BTreeMap<String, u64>> {
    let named = |causes: &BTreeMap<Cause, u64>| {
        let there = causes.iter().filter(|(_, cycles)| **cycles > 0);
        there.map(|(cause, &cycles)| (cause.name().to_owned(), cycles)).collect()
    };
    let units = frame.units.iter().map(|(unit, causes)| (unit.clone(), named(causes)));
    units.filter(|(_, causes): &(String, BTreeMap<_, _>)| !causes.is_empty()).collect()
}

/// Replays a stream, and writes the timeline of `frame` to `path`.
fn timeline(
    machine: &MachineSpec,
    level: Exact,
    header: &Header,
    stream: &[Item],
    frame: u32,
    path: &Path,
) -> Result<MachineStats, String> {
    let mut timeline = Timeline::create(machine, header, Some(frame), path).map_err(|error| error.to_string())?;
    let replay = Replay::new(machine, header).map_err(|error| error.to_string())?.fidelity(level);
    let observed = replay.observe(&mut timeline).map_err(|error| error.to_string())?;
    let stats = observed.run(stream.iter().cloned().map(Ok)).map_err(|error| error.to_string())?;
    timeline.finish().map_err(|error| error.to_string())?;
    Ok(stats)
}

#[test]
fn slices_of_random_machines_sum_to_the_frames_causes_and_both_engines_write_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("timeline");
    check_many(
        24,
        || (machines(), streams(), 0..3u32),
        |(machine, stream, frame)| {
            let (header, stream) = numbered(&stream, 0);
            let frame = frame % header.frames.len().max(1) as u32;
            let mut written = Vec::new();
            for level in [Exact::Event, Exact::Cycle] {
                let stats = timeline(&machine, level, &header, &stream, frame, &path)?;
                let bytes = std::fs::read(&path).map_err(|error| error.to_string())?;
                let (shown, own) = (read(&bytes), &stats.frames[frame as usize]);
                if shown.units() != causes(own) {
                    return Err(format!("{level:?} shows {:#?}, counted was {:#?}", shown.units(), causes(own)));
                }
                let opened = shown.slices.iter().filter(|slice| slice.1 == "row open").count() as u64;
                if frame == 0 && machine.dram.model == Model::Banks && opened != own.dram.activates {
                    return Err(format!("{opened} rows are shown, {} were opened", own.dram.activates));
                }
                written.push(bytes);
            }
            if written[0] != written[1] { Err("the engines write different timelines".into()) } else { Ok(()) }
        },
    );
}

#[test]
fn a_timeline_is_small_and_shows_queues_and_misses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("timeline");
    let rays = bvh_like(3, 1000, 12, 2);
    let (header, stream) = numbered(&frame(FrameInfo::default(), &rays, &[], 64), 0);
    let machine = MachineSpec::default();
    timeline(&machine, Exact::Event, &header, &stream, 0, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let shown = read(&bytes);
    let events = 2 * shown.slices.len() + shown.counts.len();
    assert!(bytes.len() < 20 * events, "{} bytes for {events} events", bytes.len());
    let most = |kind: &str| {
        let own = shown.counts.iter().filter(|(track, ..)| shown.kind(*track) == kind);
        own.map(|&(.., value)| value).max().unwrap_or(0)
    };
    assert!(most("in_fifo") > 0 && most("l1_traversal") > 0 && most("l2") > 0 && most("intersection") > 0);
    assert_eq!(most("list"), 0, "a tree of boxes has no lists");
    // Adjacent slices of a track have different causes.
    let mut last: BTreeMap<u64, (&str, u64)> = BTreeMap::new();
    for (track, name, begin, end) in &shown.slices {
        assert!(last.insert(*track, (name, *end)).is_none_or(|(before, ended)| before != name || ended < *begin));
    }
}

#[test]
fn a_frame_that_is_not_there_is_refused() {
    let header = |frames: &[u32], warmup: &[u32]| Header {
        frames: frames.to_vec(),
        warmup: warmup.to_vec(),
        ..crate::engine::tests::synthetic::header()
    };
    let refused = |frames: &[u32], warmup: &[u32], frame| {
        let path = Path::new("-");
        let made = Timeline::create(&MachineSpec::default(), &header(frames, warmup), frame, path);
        made.err().unwrap().to_string()
    };
    assert_eq!(refused(&[3, 4, 9], &[], Some(5)), "there is no frame 5: the stream has 3 frames from 3 to 9");
    assert_eq!(refused(&[3], &[], Some(5)), "there is no frame 5: the stream has frame 3 alone");
    let warm = "the stream has no measured frame: `--timeline-frame` names one that warms up";
    assert_eq!(refused(&[3], &[3], None), warm);
}

#[test]
fn levels_that_skip_cycles_are_refused_by_name() {
    let error = Fidelity::Profile.exact().unwrap_err().to_string();
    assert_eq!(error, "`Profile` does not replay cycle by cycle, and cannot be watched: Event and Cycle can");
}
