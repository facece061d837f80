//! Ray streams: bytes changed as they are, and contents changed under checksums that are right.

use std::io::Cursor;
use std::path::Path;

use umbrasim::machine::MachineSpec;
use umbrasim::replay::{Level, OnePass, Replay};
use umbrasim::stream::StreamReader;

use super::mutation::Random;
use super::{cases, is_limited};

/// A recorded stream, of which the first frame is taken: the replays are to be short.
const STREAM: &[u8] = include_bytes!("../../traces/quickstart.rays");
/// One of an earlier version.
const OLD_STREAM: &[u8] = include_bytes!("../fixtures/version_2/published.rays");
/// Changed streams of each kind.
const CASES: usize = 400;

/// Reads a stream and replays what can be read.
fn replay(bytes: &[u8], levels: &[Level]) -> usize {
    let Ok(reader) = StreamReader::new(Cursor::new(bytes), Path::new("fuzz.rays")) else { return 0 };
    let header = reader.header().clone();
    let machine = MachineSpec::default();
    for &level in levels {
        let items = StreamReader::new(Cursor::new(bytes), Path::new("fuzz.rays")).into_iter().flatten();
        // An error is as good as a result; a panic is not.
        let _ = Replay::new(&machine, &header).map(|replay| replay.fidelity(OnePass::Whole(level)).run(items));
    }
    1
}

#[test]
fn changed_bytes() {
    if !is_limited("streams::changed_bytes") {
        return;
    }
    let small = [STREAM, OLD_STREAM].map(|stream| Parts::of(stream).first_frame());
    let mut random = Random(1);
    for case in 0..cases(CASES) {
        let mut bytes = small[case % 2].clone();
        random.change_bytes(&mut bytes);
        replay(&bytes, &[Level::Bound]);
    }
    small.iter().for_each(|stream| assert_eq!(replay(stream, &[Level::Bound, Level::Event]), 1));
}

#[test]
fn changed_contents_with_right_checksums() {
    if !is_limited("streams::changed_contents_with_right_checksums") {
        return;
    }
    let whole = [STREAM, OLD_STREAM].map(|stream| Parts::of(&Parts::of(stream).first_frame()));
    for stream in &whole {
        assert_eq!(replay(&stream.sealed(), &[]), 1, "a stream that was taken apart and put together is one");
    }
    let mut random = Random(2);
    let mut opened = 0;
    for case in 0..cases(CASES) {
        let mut parts = whole[case / 2 % 2].clone();
        if case % 2 == 0 {
            parts.header = random.change_text(&parts.header);
        } else {
            let block = random.below(parts.blocks.len());
            random.change_bytes(&mut parts.blocks[block].1);
        }
        opened += replay(&parts.sealed(), &[Level::Bound, Level::Profile]);
    }
    assert!(opened > cases(CASES) / 4, "only {opened} of {} could be opened", cases(CASES));
}

/// A stream's parts, as `stream::format` lays them out.
#[derive(Clone)]
struct Parts {
    /// Magic and version.
    front: [u8; 12],
    header: String,
    /// Tag and payload of each block, the index last.
    blocks: Vec<([u8; 4], Vec<u8>)>,
}

impl Parts {
    fn of(bytes: &[u8]) -> Self {
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let mut at = 20 + number(12);
        let header = String::from_utf8(bytes[20..at].to_vec()).unwrap();
        let mut blocks = Vec::new();
        while at < bytes.len() - 20 {
            let (raw, stored) = (number(at + 12), number(at + 16));
            let payload = lz4_flex::block::decompress(&bytes[at + 24..at + 24 + stored], raw).unwrap();
            blocks.push((bytes[at..at + 4].try_into().unwrap(), payload));
            at += 24 + stored;
        }
        Self { front: bytes[..12].try_into().unwrap(), header, blocks }
    }

    /// The file of the first frame alone.
    fn first_frame(mut self) -> Vec<u8> {
        let mut header: serde_json::Value = serde_json::from_str(&self.header).unwrap();
        let frames = header["frames"].as_array().unwrap().len();
        let first = header["frames"][0].clone();
        header["frames"] = vec![first].into();
        self.header = header.to_string();
        let end = self.blocks.iter().position(|(tag, _)| tag == b"FEND").unwrap();
        let mut index = self.blocks.pop().unwrap();
        // Entries of frames, then four bytes for each static primitive.
        let primitives = header["static_primitives"].as_u64().unwrap() as usize;
        let entry = (index.1.len() - 4 * primitives) / frames;
        index.1.drain(entry..entry * frames);
        self.blocks.truncate(end + 1);
        self.blocks.push(index);
        self.sealed()
    }

    /// The file, with lengths, offsets and checksums that fit.
    fn sealed(&self) -> Vec<u8> {
        let mut bytes = self.front.to_vec();
        bytes.extend((self.header.len() as u32).to_le_bytes());
        let seed = crc(0, &[&bytes, self.header.as_bytes()]);
        bytes.extend(seed.to_le_bytes());
        bytes.extend(self.header.as_bytes());
        let (index, blocks) = self.blocks.split_last().unwrap();
        let (mut index, begin) = (index.clone(), bytes.len());
        for (number, block) in blocks.iter().enumerate() {
            put(&mut bytes, seed, number, block);
        }
        let end = bytes.len();
        // The entry of the one frame: its offset, bytes, payload bytes and blocks.
        let raw: usize = blocks.iter().map(|(_, payload)| payload.len()).sum();
        for (at, value) in [(4, begin), (12, end - begin), (20, raw), (36, blocks.len())] {
            if let Some(place) = index.1.get_mut(at..at + 8) {
                place.copy_from_slice(&(value as u64).to_le_bytes());
            }
        }
        put(&mut bytes, seed, blocks.len(), &index);
        let offset = (end as u64).to_le_bytes();
        bytes.extend(offset);
        bytes.extend(crc(seed, &[&offset]).to_le_bytes());
        bytes.extend(b"RAYS-END");
        bytes
    }
}

fn put(bytes: &mut Vec<u8>, seed: u32, number: usize, (tag, payload): &([u8; 4], Vec<u8>)) {
    let stored = lz4_flex::block::compress(payload);
    let mut front = tag.to_vec();
    front.extend((number as u64).to_le_bytes());
    front.extend((payload.len() as u32).to_le_bytes());
    front.extend((stored.len() as u32).to_le_bytes());
    let sum = crc(seed, &[&front, &stored]);
    bytes.extend(front);
    bytes.extend(sum.to_le_bytes());
    bytes.extend(stored);
}

fn crc(seed: u32, parts: &[&[u8]]) -> u32 {
    let mut crc = crc32fast::Hasher::new_with_initial(seed);
    parts.iter().for_each(|part| crc.update(part));
    crc.finalize()
}
