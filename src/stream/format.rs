//! The layout of a ray stream file (`*.rays`), byte by byte. All integers are little-endian.
//!
//! ```text
//! file      = preamble, blocks of frame 0, blocks of frame 1, ..., index block, footer
//! frame     = FRAM block, any number of RAYS blocks, FEND block
//!
//! preamble    0  8  magic: 89 "RAYS" 0D 0A 1A
//!             8  4  version
//!            12  4  length of the header's text, at most HEADER_LIMIT
//!            16  4  CRC-32 of bytes 0 to 15 and of the text: the file's seed
//!            20  .  the header (stream::Header) as JSON
//!
//! block       0  4  tag: "FRAM", "RAYS", "FEND" or "INDX"
//!             4  8  the block's number: 0, 1, 2, ... through the whole file
//!            12  4  length of the payload, at most RAW_LIMIT
//!            16  4  length of the payload as stored
//!            20  4  CRC-32 that starts from the file's seed, of bytes 0 to 19 and of the payload as stored
//!            24  .  the payload as an LZ4 block
//!
//! FRAM        0  4  the frame's number, then three more: dynamic nodes, slots, list entries
//! RAYS               see the module `columns`
//! FEND        0 128  totals: 16 integers of 8 bytes in the order of stream::Totals
//!           128  .  the policy's steps at the frame's end, 4 bytes each
//! INDX               for each frame 172 bytes, then for each static primitive 4 bytes, its triangle record
//!                    (ffffffff: none). A frame's:
//!             0  4  the frame's number
//!             4  8  offset of its FRAM block in the file
//!            12  8  bytes of its blocks in the file
//!            20  8  bytes of its payloads
//!            28  8  its rays
//!            36  8  its blocks
//!            44 128  its totals, as in FEND
//!
//! footer      0  8  offset of the INDX block in the file
//!             8  4  CRC-32 that starts from the file's seed, of bytes 0 to 7
//!            12  8  magic: "RAYS-END"
//! ```
//!
//! The seed ties each block to its file, and the number to its place. A block of another file, or one that was moved,
//! lost or doubled, is refused even if its own bytes are intact.
//!
//! This is version 3. Version 2 can be read too: the module `version` describes the differences.

use super::fault::Fault;
use super::item::FrameInfo;
use super::totals::Totals;
use super::version::Version;
use crate::quantity::{Bytes, TriangleSlot};

/// The first bytes of a file. As in PNG, the byte above 127 and the line ends reveal a transfer that changed bytes.
pub(crate) const MAGIC: [u8; 8] = *b"\x89RAYS\r\n\x1a";
/// The last bytes of a file.
pub(crate) const END_MAGIC: [u8; 8] = *b"RAYS-END";
/// Bytes before the header's text.
pub(crate) const PREAMBLE_BYTES: usize = 20;
/// Bytes of a block before its payload.
pub(crate) const BLOCK_BYTES: usize = 24;
/// Bytes of the footer.
pub(crate) const FOOTER_BYTES: usize = 20;
/// The longest header text, in bytes: room for some 150,000 frame numbers.
pub(crate) const HEADER_LIMIT: usize = 1 << 20;
/// The longest payload before compression, in bytes. It bounds the memory of a reader: payload, stored payload and
/// decoded chunk, each about as large at most.
pub(crate) const RAW_LIMIT: usize = 64 << 20;

/// Bytes of a FRAM payload.
const FRAME_INFO_BYTES: usize = 16;
/// Bytes of a frame in the INDX payload before its totals.
const ENTRY_BYTES: usize = 44;

/// Bytes of totals.
fn totals_bytes(version: Version) -> usize {
    8 * version.totals()
}

/// What a block holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tag {
    /// A frame begins.
    Frame,
    /// Rays.
    Rays,
    /// A frame ends.
    End,
    /// The index of frames.
    Index,
}

impl Tag {
    const ALL: [Self; 4] = [Self::Frame, Self::Rays, Self::End, Self::Index];

    /// The tag's bytes in the file.
    pub(crate) fn bytes(self) -> [u8; 4] {
        match self {
            Self::Frame => *b"FRAM",
            Self::Rays => *b"RAYS",
            Self::End => *b"FEND",
            Self::Index => *b"INDX",
        }
    }
}

/// The fixed part of a block, without its checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BlockHeader {
    /// What the block holds.
    pub tag: Tag,
    /// Its place among the file's blocks.
    pub number: u64,
    /// Length of the payload in bytes.
    pub raw: usize,
    /// Length of the payload as stored, in bytes.
    pub stored: usize,
}

impl BlockHeader {
    /// The fixed part in front of the payload `stored`, with the checksum of both.
    pub(crate) fn encode(&self, seed: u32, stored: &[u8]) -> [u8; BLOCK_BYTES] {
        let mut bytes = [0; BLOCK_BYTES];
        bytes[..4].copy_from_slice(&self.tag.bytes());
        bytes[4..12].copy_from_slice(&self.number.to_le_bytes());
        bytes[12..16].copy_from_slice(&(self.raw as u32).to_le_bytes());
        bytes[16..20].copy_from_slice(&(self.stored as u32).to_le_bytes());
        let sum = checksum(seed, &[&bytes[..20], stored]);
        bytes[20..].copy_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// The fixed part, checked as far as possible before the payload is read. `number` is the number that the block
    /// must have, `room` the bytes between the fixed part and the end of the area that holds the block. A valid payload
    /// has at most `room` bytes and unpacks to at most [`RAW_LIMIT`].
    pub(crate) fn decode(bytes: &[u8; BLOCK_BYTES], number: u64, room: u64) -> Result<Self, Fault> {
        let tag: [u8; 4] = field(bytes, 0);
        let tag = Tag::ALL.into_iter().find(|known| known.bytes() == tag).ok_or(Fault::Tag { found: tag })?;
        let header = Self {
            tag,
            number: u64::from_le_bytes(field(bytes, 4)),
            raw: u32::from_le_bytes(field(bytes, 12)) as usize,
            stored: u32::from_le_bytes(field(bytes, 16)) as usize,
        };
        if header.number != number {
            return Err(Fault::Number { found: header.number, expected: number });
        }
        // A byte of an LZ4 block expands to 255 bytes at most.
        let limit = RAW_LIMIT.min(header.stored.saturating_mul(255));
        if header.raw > limit {
            return Err(Fault::TooLarge { found: header.raw as u64, limit: limit as u64 });
        }
        if header.stored as u64 > room {
            return Err(Fault::TooLarge { found: header.stored as u64, limit: room });
        }
        Ok(header)
    }
}

/// CRC-32 (IEEE 802.3) of `parts` one after another, started from the checksum `seed`.
pub(crate) fn checksum(seed: u32, parts: &[&[u8]]) -> u32 {
    let mut hasher = crc32fast::Hasher::new_with_initial(seed);
    for part in parts {
        hasher.update(part);
    }
    hasher.finalize()
}

/// `N` bytes of `bytes` from `at` on.
///
/// # Panics
/// If `bytes` is too short: callers check lengths first.
pub(crate) fn field<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let mut field = [0; N];
    field.copy_from_slice(&bytes[at..at + N]);
    field
}

/// Appends `words`, 4 bytes each.
pub(crate) fn put_words(words: &[u32], out: &mut Vec<u8>) {
    let start = out.len();
    out.resize(start + 4 * words.len(), 0);
    for (bytes, word) in out[start..].as_chunks_mut().0.iter_mut().zip(words) {
        *bytes = word.to_le_bytes();
    }
}

/// The words that `bytes` holds, 4 bytes each.
pub(crate) fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect()
}

/// Appends a FRAM payload.
pub(crate) fn put_frame(info: &FrameInfo, out: &mut Vec<u8>) {
    let FrameInfo { number, dynamic_nodes, dynamic_slots, dynamic_list_entries } = *info;
    put_words(&[number, dynamic_nodes, dynamic_slots, dynamic_list_entries], out);
}

/// Reads a FRAM payload.
pub(crate) fn frame(payload: &[u8]) -> Result<FrameInfo, Fault> {
    if payload.len() != FRAME_INFO_BYTES {
        return Err(Fault::Length { found: payload.len(), expected: FRAME_INFO_BYTES });
    }
    let [number, dynamic_nodes, dynamic_slots, dynamic_list_entries] =
        [0, 4, 8, 12].map(|at| u32::from_le_bytes(field(payload, at)));
    Ok(FrameInfo { number, dynamic_nodes, dynamic_slots, dynamic_list_entries })
}

/// Appends a FEND payload.
pub(crate) fn put_end(policy: &[u32], totals: &Totals, out: &mut Vec<u8>) {
    put_totals(totals, out);
    put_words(policy, out);
}

/// Length of a FEND payload.
pub(crate) fn end_len(policy: &[u32]) -> usize {
    totals_bytes(Version::CURRENT) + 4 * policy.len()
}

/// Reads a FEND payload: the policy's steps, packed and not yet checked, and the totals.
pub(crate) fn end(payload: &[u8], version: Version) -> Result<(Vec<u32>, Totals), Fault> {
    let front = totals_bytes(version);
    let expected = front + payload.len().saturating_sub(front) / 4 * 4;
    if payload.len() != expected {
        return Err(Fault::Length { found: payload.len(), expected });
    }
    let (counters, steps) = payload.split_at(front);
    Ok((version.steps(words(steps))?, totals(counters)))
}

/// A frame in the index.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FrameEntry {
    /// The frame's number.
    pub number: u32,
    /// Offset of its first block in the file.
    pub offset: u64,
    /// Bytes of its blocks in the file.
    pub bytes: Bytes,
    /// Bytes of its payloads before compression.
    pub raw_bytes: Bytes,
    /// Rays.
    pub rays: u64,
    /// Blocks.
    pub blocks: u64,
    /// The tracer's counters.
    pub totals: Totals,
}

/// Appends an INDX payload.
pub(crate) fn put_index(entries: &[FrameEntry], records: &[TriangleSlot], out: &mut Vec<u8>) {
    for entry in entries {
        let FrameEntry { number, offset, bytes, raw_bytes, rays, blocks, totals } = *entry;
        out.extend(number.to_le_bytes());
        out.extend([offset, bytes.0, raw_bytes.0, rays, blocks].into_iter().flat_map(u64::to_le_bytes));
        put_totals(&totals, out);
    }
    out.extend(records.iter().flat_map(|record| record.0.to_le_bytes()));
}

/// Length of an INDX payload.
pub(crate) fn index_len(frames: usize, primitives: usize, version: Version) -> usize {
    let entry = ENTRY_BYTES + totals_bytes(version);
    frames.saturating_mul(entry).saturating_add(primitives.saturating_mul(4))
}

/// Reads an INDX payload of `frames` frames and `primitives` static primitives: the frames, and the primitives'
/// records.
pub(crate) fn index(
    payload: &[u8],
    frames: usize,
    primitives: usize,
    version: Version,
) -> Result<(Vec<FrameEntry>, Vec<TriangleSlot>), Fault> {
    let expected = index_len(frames, primitives, version);
    if payload.len() != expected {
        return Err(Fault::Length { found: payload.len(), expected });
    }
    let (payload, records) = payload.split_at(index_len(frames, 0, version));
    let entry = |bytes: &[u8]| {
        let [offset, size, raw_bytes, rays, blocks] =
            [4, 12, 20, 28, 36].map(|at| u64::from_le_bytes(field(bytes, at)));
        FrameEntry {
            number: u32::from_le_bytes(field(bytes, 0)),
            offset,
            bytes: Bytes(size),
            raw_bytes: Bytes(raw_bytes),
            rays,
            blocks,
            totals: totals(&bytes[ENTRY_BYTES..]),
        }
    };
    let entries = payload.chunks_exact(ENTRY_BYTES + totals_bytes(version)).map(entry);
    Ok((entries.collect(), words(records).into_iter().map(TriangleSlot).collect()))
}

fn put_totals(totals: &Totals, out: &mut Vec<u8>) {
    out.extend(totals.values().into_iter().flat_map(u64::to_le_bytes));
}

/// The totals that `bytes` hold; counters that the file's version does not have are 0.
fn totals(bytes: &[u8]) -> Totals {
    let mut values = bytes.as_chunks().0.iter().map(|&value| u64::from_le_bytes(value));
    Totals::from_values(std::array::from_fn(|_| values.next().unwrap_or(0)))
}
