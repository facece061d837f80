//! Reads a ray stream file block by block: preamble, blocks, index and footer.

use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::error::{Place, StreamError};
use super::fault::Fault;
use super::format::{
    self, BLOCK_BYTES, BlockHeader, END_MAGIC, FOOTER_BYTES, FrameEntry, HEADER_LIMIT, MAGIC, PREAMBLE_BYTES, Tag,
    checksum, field,
};
use super::header::Header;
use super::totals::Totals;
use super::version::Version;
use crate::json;

/// The first field in which a frame's index entry differs from what was read of the frame.
pub(super) fn difference(index: &FrameEntry, seen: &FrameEntry) -> Option<Fault> {
    let values = |entry: &FrameEntry| {
        let FrameEntry { number, offset, bytes, raw_bytes, rays, blocks, totals } = *entry;
        let own = [number.into(), offset, bytes.0, raw_bytes.0, rays, blocks];
        own.into_iter().chain(totals.values())
    };
    let names = ["number", "offset", "bytes", "raw_bytes", "rays", "blocks"].into_iter();
    let names = names.chain(Totals::DECLARED.iter().map(|counter| counter.name));
    let mut all = names.zip(values(index)).zip(values(seen));
    all.find_map(|((what, index), found)| {
        (index != found).then_some(Fault::Index { frame: seen.number, what, index, found })
    })
}

/// The blocks of a file, in order.
pub(super) struct Blocks<R> {
    input: R,
    pub path: PathBuf,
    pub version: Version,
    seed: u32,
    /// Offset of the next byte to read.
    pub position: u64,
    /// Number of the next block.
    pub number: u64,
    stored: Vec<u8>,
    /// The payload of the block that was read last.
    pub raw: Vec<u8>,
}

impl<R: Read + Seek> Blocks<R> {
    /// The blocks of a stream that fills `input`; errors name `path`.
    pub(super) fn new(input: R, path: &Path) -> Self {
        let path = path.to_owned();
        let version = Version::CURRENT;
        Self { input, path, version, seed: 0, position: 0, number: 0, stored: Vec::new(), raw: Vec::new() }
    }

    /// The file's length in bytes.
    pub(super) fn length(&mut self) -> Result<u64, StreamError> {
        self.input.seek(SeekFrom::End(0)).map_err(|source| self.io(source))
    }

    fn io(&self, source: std::io::Error) -> StreamError {
        if source.kind() == ErrorKind::UnexpectedEof {
            self.cut_off("it became shorter while it was read")
        } else {
            StreamError::Io { path: self.path.clone(), doing: "read", source }
        }
    }

    fn cut_off(&self, missing: &'static str) -> StreamError {
        StreamError::CutOff { path: self.path.clone(), missing }
    }

    fn corrupt(&self, place: Place, fault: Fault) -> StreamError {
        StreamError::Corrupt { path: self.path.clone(), place, fault }
    }

    /// Continues at byte `position` of the file.
    pub(super) fn seek(&mut self, position: u64) -> Result<(), StreamError> {
        self.input.seek(SeekFrom::Start(position)).map_err(|source| self.io(source))?;
        self.position = position;
        Ok(())
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), StreamError> {
        self.input.read_exact(bytes).map_err(|source| self.io(source))?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    /// Reads the header of a file of `length` bytes and stores the file's version and seed.
    pub(super) fn preamble(&mut self, length: u64) -> Result<Header, StreamError> {
        self.seek(0)?;
        let mut front = [0; PREAMBLE_BYTES];
        let there = length.min(PREAMBLE_BYTES as u64) as usize;
        self.fill(&mut front[..there])?;
        let start = &front[..there.min(MAGIC.len())];
        if start.is_empty() || !MAGIC.starts_with(start) {
            let found = match start {
                [] => "it is empty".to_owned(),
                _ => format!("it begins with `{}`", start.escape_ascii()),
            };
            return Err(StreamError::Foreign { path: self.path.clone(), found });
        }
        if there >= 12 {
            let found = u32::from_le_bytes(field(&front, 8));
            let unknown = || StreamError::Version { path: self.path.clone(), found };
            self.version = Version::of(found).ok_or_else(unknown)?;
        }
        let text = u32::from_le_bytes(field(&front, 12)) as usize;
        if there == PREAMBLE_BYTES && text > HEADER_LIMIT {
            let fault = Fault::TooLarge { found: text as u64, limit: HEADER_LIMIT as u64 };
            return Err(self.corrupt(Place::Header, fault));
        }
        if length < (PREAMBLE_BYTES + text) as u64 || there < PREAMBLE_BYTES {
            return Err(self.cut_off("its header is not whole"));
        }
        let mut bytes = vec![0; text];
        self.fill(&mut bytes)?;
        self.seed = checksum(0, &[&front[..16], &bytes]);
        if self.seed != u32::from_le_bytes(field(&front, 16)) {
            return Err(self.corrupt(Place::Header, Fault::Checksum));
        }
        let unread = |error: serde_json::Error| self.corrupt(Place::Header, Fault::Header(error.to_string()));
        let header: Header = json::read(&bytes).map_err(unread)?;
        Ok(Header { unjudged_updates: self.version == Version::Two || header.unjudged_updates, ..header })
    }

    /// Reads the index of a file of `length` bytes, after [`Blocks::preamble`]. Returns the entries and the offset at
    /// which the blocks of frames end; sets the header's records.
    pub(super) fn index(&mut self, header: &mut Header, length: u64) -> Result<(Vec<FrameEntry>, u64), StreamError> {
        let begin = self.position;
        let missing = "its end is missing, so that it was not completed or a part was lost";
        if length < begin + (BLOCK_BYTES + FOOTER_BYTES) as u64 {
            return Err(self.cut_off(missing));
        }
        let footer_at = length - FOOTER_BYTES as u64;
        self.seek(footer_at)?;
        let mut footer = [0; FOOTER_BYTES];
        self.fill(&mut footer)?;
        if footer[12..] != END_MAGIC {
            return Err(self.cut_off("its end is not that of a stream: a part was lost, or something was appended"));
        }
        if checksum(self.seed, &[&footer[..8]]) != u32::from_le_bytes(field(&footer, 8)) {
            return Err(self.corrupt(Place::Footer, Fault::Checksum));
        }
        let offset = u64::from_le_bytes(field(&footer, 0));
        if !(begin..=footer_at - BLOCK_BYTES as u64).contains(&offset) {
            return Err(self.corrupt(Place::Footer, Fault::Offset { offset }));
        }
        self.seek(offset)?;
        // The index block's number equals the number of blocks of all frames; the entries must add up to it.
        let mut front = [0; BLOCK_BYTES];
        self.fill(&mut front)?;
        self.seek(offset)?;
        let blocks = u64::from_le_bytes(field(&front, 4));
        let possible = (offset - begin) / BLOCK_BYTES as u64;
        if blocks > possible {
            return Err(self.corrupt(Place::Index, Fault::Number { found: blocks, expected: possible }));
        }
        self.number = blocks;
        if self.read(Place::Index, footer_at)? != Tag::Index || self.position != footer_at {
            return Err(self.corrupt(Place::Index, Fault::Kind));
        }
        let (frames, primitives) = (header.frames.len(), header.static_primitives as usize);
        let index = format::index(&self.raw, frames, primitives, self.version);
        let (entries, records) = index.map_err(|fault| self.corrupt(Place::Index, fault))?;
        header.records = records.into();
        // Frames follow each other without a gap from the preamble to the index, each as large as its entry says.
        let mut next = FrameEntry { offset: begin, ..FrameEntry::default() };
        for (entry, &number) in entries.iter().zip(&header.frames) {
            let expected = FrameEntry { number, offset: next.offset, ..*entry };
            if let Some(fault) = difference(entry, &expected) {
                return Err(self.corrupt(Place::Index, fault));
            }
            next.offset = next.offset.saturating_add(entry.bytes.0);
            next.blocks = next.blocks.saturating_add(entry.blocks);
        }
        if next.offset != offset {
            return Err(self.corrupt(Place::Footer, Fault::Offset { offset }));
        }
        if next.blocks != blocks {
            return Err(self.corrupt(Place::Index, Fault::Number { found: blocks, expected: next.blocks }));
        }
        Ok((entries, offset))
    }

    /// Reads the next block, which must end at byte `end` or before, into `self.raw`.
    pub(super) fn read(&mut self, place: Place, end: u64) -> Result<Tag, StreamError> {
        let mut front = [0; BLOCK_BYTES];
        let area = end.saturating_sub(self.position);
        let Some(room) = area.checked_sub(BLOCK_BYTES as u64) else {
            return Err(self.corrupt(place, Fault::TooLarge { found: BLOCK_BYTES as u64, limit: area }));
        };
        self.fill(&mut front)?;
        let header = BlockHeader::decode(&front, self.number, room).map_err(|fault| self.corrupt(place, fault))?;
        let mut stored = std::mem::take(&mut self.stored);
        stored.resize(header.stored, 0);
        self.fill(&mut stored)?;
        self.stored = stored;
        if front != header.encode(self.seed, &self.stored) {
            return Err(self.corrupt(place, Fault::Checksum));
        }
        self.raw.resize(header.raw, 0);
        let unpacked = lz4_flex::block::decompress_into(&self.stored, &mut self.raw);
        if !unpacked.is_ok_and(|bytes| bytes == header.raw) {
            return Err(self.corrupt(place, Fault::Compression { raw: header.raw }));
        }
        self.number += 1;
        Ok(header.tag)
    }
}
