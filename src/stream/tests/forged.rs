//! Files with correct checksums and wrong contents are refused.

use super::super::format::{BlockHeader, END_MAGIC, RAW_LIMIT, Tag, checksum};
use super::super::version::Version;
use super::super::violation::{RayFault, StepFault};
use super::*;

/// A file with a header for frame 0 only and with `blocks`; checksums, index and footer fit them.
fn forged(blocks: &[(Tag, u64, usize, Vec<u8>)], entry: impl FnOnce(&mut FrameEntry)) -> Vec<u8> {
    let header = header(&[0]);
    let whole = written(&header, &frame(0, vec![], vec![]));
    let begin = PREAMBLE_BYTES + u32::from_le_bytes(field(&whole, 12)) as usize;
    let seed = u32::from_le_bytes(field(&whole, 16));
    let mut bytes = whole[..begin].to_vec();
    let put = |bytes: &mut Vec<u8>, tag, number, raw, stored: &[u8]| {
        let header = BlockHeader { tag, number, raw, stored: stored.len() };
        bytes.extend(header.encode(seed, stored));
        bytes.extend(stored);
    };
    for (tag, number, raw, stored) in blocks {
        put(&mut bytes, *tag, *number, *raw, stored);
    }
    let end = bytes.len() as u64;
    let mut only = FrameEntry { offset: begin as u64, blocks: blocks.len() as u64, ..FrameEntry::default() };
    only.bytes.0 = end - begin as u64;
    only.raw_bytes.0 = blocks.iter().map(|block| block.2 as u64).sum();
    entry(&mut only);
    let mut index = Vec::new();
    format::put_index(&[only], &header.records, &mut index);
    put(&mut bytes, Tag::Index, blocks.len() as u64, index.len(), &lz4_flex::block::compress(&index));
    bytes.extend(end.to_le_bytes());
    bytes.extend(checksum(seed, &[&end.to_le_bytes()]).to_le_bytes());
    bytes.extend(END_MAGIC);
    bytes
}

fn block(tag: Tag, number: u64, payload: &[u8]) -> (Tag, u64, usize, Vec<u8>) {
    (tag, number, payload.len(), lz4_flex::block::compress(payload))
}

fn frame_block() -> (Tag, u64, usize, Vec<u8>) {
    let mut payload = Vec::new();
    format::put_frame(&info(0), &mut payload);
    block(Tag::Frame, 0, &payload)
}

fn end_block(number: u64) -> (Tag, u64, usize, Vec<u8>) {
    let mut payload = Vec::new();
    format::put_end(&[], &Totals::default(), &mut payload);
    block(Tag::End, number, &payload)
}

fn fault(bytes: &[u8]) -> (Place, Fault) {
    match read(bytes) {
        Err(StreamError::Corrupt { place, fault, .. }) => (place, fault),
        other => panic!("{other:?}"),
    }
}

#[test]
fn forged_files_are_refused() {
    assert!(read(&forged(&[frame_block(), end_block(1)], |_| ())).is_ok(), "the forge works");

    let at = |block| Place::Block { frame: Some(0), block };
    let bytes = forged(&[frame_block(), end_block(2)], |_| ());
    assert_eq!(fault(&bytes), (at(1), Fault::Number { found: 2, expected: 1 }));
    let bytes = forged(&[frame_block(), block(Tag::Index, 1, b"index")], |_| ());
    assert_eq!(fault(&bytes), (at(1), Fault::Kind));
    let bytes = forged(&[frame_block(), block(Tag::Rays, 1, b"rays")], |_| ());
    assert_eq!(fault(&bytes), (at(1), Fault::Length { found: 4, expected: 8 }));
    let bytes = forged(&[frame_block(), block(Tag::Rays, 1, &[0xff; 30])], |_| ());
    assert!(matches!(fault(&bytes), (_, Fault::Length { found: 30, .. })));
    let bytes = forged(&[frame_block(), block(Tag::End, 1, &[0; 129])], |_| ());
    assert_eq!(fault(&bytes), (at(1), Fault::Length { found: 129, expected: 128 }));
    let bytes = forged(&[block(Tag::Frame, 0, &[0; 15])], |_| ());
    assert!(matches!(fault(&bytes), (_, Fault::Length { found: 15, expected: 16 })));

    // Payloads that do not unpack to the stated length.
    let (tag, number, raw, stored) = end_block(1);
    for raw in [raw - 1, raw + 1] {
        let bytes = forged(&[frame_block(), (tag, number, raw, stored.clone())], |_| ());
        assert_eq!(fault(&bytes), (at(1), Fault::Compression { raw }));
    }

    // An index that does not fit the frame: found when the frame is read.
    let bytes = forged(&[frame_block(), end_block(1)], |entry| entry.rays = 4);
    assert_eq!(fault(&bytes), (Place::Index, Fault::Index { frame: 0, what: "rays", index: 4, found: 0 }));
    let bytes = forged(&[frame_block(), end_block(1)], |entry| entry.totals.node_visits = 1);
    assert!(matches!(fault(&bytes), (Place::Index, Fault::Index { what: "node_visits", .. })));
    // An index that does not fit the file: found when the file is opened.
    for change in [|entry: &mut FrameEntry| entry.bytes.0 += 1, |entry: &mut FrameEntry| entry.offset = u64::MAX] {
        let bytes = forged(&[frame_block(), end_block(1)], change);
        assert!(StreamReader::new(Cursor::new(bytes), Path::new(PATH)).is_err());
    }
    for blocks in [1, 3, u64::MAX] {
        let bytes = forged(&[frame_block(), end_block(1)], |entry| entry.blocks = blocks);
        assert!(matches!(fault(&bytes), (Place::Index, Fault::Number { .. })));
    }

    // The order of items.
    let bytes = forged(&[end_block(0)], |_| ());
    assert!(matches!(read(&bytes), Err(StreamError::Invalid { violation: Violation::Order { .. }, .. })));
    // A frame without an end.
    let bytes = forged(&[frame_block()], |_| ());
    assert!(matches!(fault(&bytes), (_, Fault::TooLarge { found: 24, limit: 0 })));
}

#[test]
fn chunks_with_impossible_columns_are_refused() {
    let mut good = Vec::new();
    columns::put_chunk(&small_chunk(), &mut good);
    assert_eq!(columns::chunk(&good, Version::CURRENT).unwrap(), small_chunk());
    let with = |at: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[at] = byte;
        columns::chunk(&bytes, Version::CURRENT)
    };
    // Offsets of the columns of three rays: classes 8, lights 11, primitives 14, pixels 26, parents 38, path lengths
    // 50.
    assert!(matches!(with(8, 0b0100_0000), Err(Fault::Class { ray: 0, .. })), "unused bits");
    assert!(matches!(with(9, 0b1101), Err(Fault::Class { ray: 1, .. })), "no decision");
    assert!(matches!(with(15, 1), Err(Fault::Class { ray: 1, primitive: 1, .. })), "a primitive without a hit");
    assert!(matches!(with(50, 5), Err(Fault::Steps { steps: 8 })), "one step more than there are");
    assert!(matches!(with(59, 0xff), Err(Fault::Steps { steps: 8 })), "steps beyond 32 bits");
}

#[test]
fn lengths_are_checked_before_memory_is_taken() {
    let bytes = |raw: u32, stored: u32| {
        let mut bytes = BlockHeader { tag: Tag::Rays, number: 3, raw: 0, stored: 0 }.encode(0, &[]);
        bytes[12..16].copy_from_slice(&raw.to_le_bytes());
        bytes[16..20].copy_from_slice(&stored.to_le_bytes());
        bytes
    };
    let refused = |raw, stored, room| match BlockHeader::decode(&bytes(raw, stored), 3, room) {
        Err(Fault::TooLarge { limit, .. }) => limit,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(u32::MAX, u32::MAX, u64::MAX), RAW_LIMIT as u64);
    assert_eq!(refused(RAW_LIMIT as u32 + 1, u32::MAX, u64::MAX), RAW_LIMIT as u64);
    assert_eq!(refused(2551, 10, 1 << 20), 2550, "10 bytes cannot become more");
    assert_eq!(refused(100, 101, 100), 100, "more than the file has");
    assert!(BlockHeader::decode(&bytes(RAW_LIMIT as u32, 1 << 20), 3, 1 << 20).is_ok());

    // A header length of 4 GiB, in a file without these bytes.
    let mut start = b"\x89RAYS\r\n\x1a".to_vec();
    start.extend(Version::CURRENT.number().to_le_bytes());
    start.extend(u32::MAX.to_le_bytes());
    start.extend([0; 4]);
    assert!(matches!(fault(&start), (Place::Header, Fault::TooLarge { .. })));
}

/// Files can hold steps that [`Chunk::push`] refuses in a debug build.
#[test]
fn steps_of_files_are_checked_before_they_are_unpacked() {
    let primary = head(RayKind::Primary, Outcome::Miss, 0);
    let write = Step::Write { store: Store::ModeWord, index: 0 };
    for (word, lengths, expected) in [
        (0xe000_0001, [1, 0], RayFault::Path(StepFault::Unknown { at: 0, word: 0xe000_0001 })),
        (0xf000_0000, [0, 1], RayFault::Policy(StepFault::Unknown { at: 0, word: 0xf000_0000 })),
        (write.pack(), [1, 0], RayFault::Path(StepFault::Id { at: 0, step: write, limit: 0 })),
    ] {
        let chunk = Chunk::from_columns([Ok::<_, Fault>((primary, lengths))].into_iter(), vec![word]).unwrap().unwrap();
        let mut payload = Vec::new();
        columns::put_chunk(&chunk, &mut payload);
        let bytes = forged(&[frame_block(), block(Tag::Rays, 1, &payload)], |_| ());
        match read(&bytes) {
            Err(StreamError::Invalid { place, violation: Violation::Ray { ray: 0, fault }, .. }) => {
                assert_eq!(place, Place::Block { frame: Some(0), block: 1 });
                assert_eq!(fault, expected);
            }
            other => panic!("{other:?}"),
        }
    }
}
