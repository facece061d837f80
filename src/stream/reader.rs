//! Reads ray stream files.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::format::{
    self, BLOCK_BYTES, BlockHeader, END_MAGIC, FOOTER_BYTES, FrameEntry, HEADER_LIMIT, MAGIC, PREAMBLE_BYTES, Tag,
    VERSION, checksum, field,
};
use super::{Checker, Fault, Header, Item, Place, StreamError, Totals, check, columns};
use crate::quantity::Bytes;

/// Reads a stream item by item: it is an iterator from the stream's start, or from the frame of
/// [`StreamReader::seek_frame`], to its end. It ends after an error.
///
/// Opening reads and checks the header and the index. Every block is checked against its checksum, every item against
/// the rules of streams, every frame against its totals and its entry of the index. Memory is bounded by
/// [`format::RAW_LIMIT`] and by the file's length, whatever the file says.
pub struct StreamReader<R = BufReader<File>> {
    blocks: Blocks<R>,
    checker: Checker,
    entries: Vec<FrameEntry>,
    /// Bytes of the file.
    length: u64,
    /// Where the blocks of frames end: the index's offset.
    end: u64,
    /// The next frame's place in `entries`, or that of the frame that is being read.
    frame: usize,
    /// What was read of the frame.
    seen: FrameEntry,
    failed: bool,
}

impl StreamReader {
    /// Opens the file `path`.
    pub fn open(path: &Path) -> Result<Self, StreamError> {
        let failed = |source| StreamError::Io { path: path.to_owned(), doing: "read", source };
        let input = File::open(path).map_err(failed)?;
        if !input.metadata().map_err(failed)?.is_file() {
            return Err(StreamError::Foreign { path: path.to_owned(), found: "it is no regular file".to_owned() });
        }
        Self::new(BufReader::new(input), path)
    }
}

impl<R: Read + Seek> StreamReader<R> {
    /// Opens the stream that is the whole of `input`; `path` is named in errors.
    pub fn new(input: R, path: &Path) -> Result<Self, StreamError> {
        let mut blocks = Blocks {
            input,
            path: path.to_owned(),
            seed: 0,
            position: 0,
            number: 0,
            stored: Vec::new(),
            raw: Vec::new(),
        };
        let length = blocks.input.seek(SeekFrom::End(0)).map_err(|source| blocks.io(source))?;
        let mut header = blocks.preamble(length)?;
        let invalid = |place, violation| StreamError::Invalid { path: path.to_owned(), place, violation };
        check::counts(&header).map_err(|violation| invalid(Place::Header, violation))?;
        let (entries, end) = blocks.index(&mut header, length)?;
        let checker = Checker::new(&header).map_err(|violation| invalid(Place::Index, violation))?;
        let seen = FrameEntry::default();
        let mut reader = Self { blocks, checker, entries, length, end, frame: 0, seen, failed: false };
        reader.seek_frame(0)?;
        Ok(reader)
    }

    /// The header.
    pub fn header(&self) -> &Header {
        self.checker.header()
    }

    /// The index: every frame in order.
    pub fn frames(&self) -> &[FrameEntry] {
        &self.entries
    }

    /// The file's length.
    pub fn file_bytes(&self) -> Bytes {
        Bytes(self.length)
    }

    /// Continues at the beginning of the frame at place `index` of [`StreamReader::frames`]; a place past the last
    /// frame is the stream's end.
    pub fn seek_frame(&mut self, index: usize) -> Result<(), StreamError> {
        self.frame = index.min(self.entries.len());
        let offset = self.entries.get(self.frame).map_or(self.end, |entry| entry.offset);
        self.blocks.seek(offset)?;
        self.blocks.number = self.entries[..self.frame].iter().map(|entry| entry.blocks).sum();
        self.checker.seek(self.frame);
        self.failed = false;
        Ok(())
    }

    /// The item of the next block.
    fn item(&mut self) -> Result<Item, StreamError> {
        let place = Place::Block { frame: self.checker.frame(), block: self.blocks.number };
        let path = self.blocks.path.clone();
        let start = self.blocks.position;
        let tag = self.blocks.read(place, self.end)?;
        let payload = &self.blocks.raw;
        let item = match tag {
            Tag::Frame => format::frame(payload).map(Item::Frame),
            Tag::Rays => columns::chunk(payload).map(|chunk| Item::Rays(Arc::new(chunk))),
            Tag::End => format::end(payload).map(|(policy, totals)| Item::End { policy: Arc::new(policy), totals }),
            Tag::Index => Err(Fault::Kind),
        };
        let item = item.map_err(|fault| StreamError::Corrupt { path: path.clone(), place, fault })?;
        self.checker.check(&item).map_err(|violation| StreamError::Invalid { path: path.clone(), place, violation })?;
        if let Item::Frame(info) = &item {
            self.seen = FrameEntry { number: info.number, offset: start, ..FrameEntry::default() };
        }
        self.seen.bytes += Bytes(self.blocks.position - start);
        self.seen.raw_bytes += Bytes(payload.len() as u64);
        self.seen.blocks += 1;
        match &item {
            Item::Frame(_) => {}
            Item::Rays(chunk) => self.seen.rays += chunk.len() as u64,
            Item::End { totals, .. } => {
                self.seen.totals = *totals;
                if let Some(fault) = difference(&self.entries[self.frame], &self.seen) {
                    return Err(StreamError::Corrupt { path, place: Place::Index, fault });
                }
                self.frame += 1;
            }
        }
        Ok(item)
    }
}

impl<R: Read + Seek> Iterator for StreamReader<R> {
    type Item = Result<Item, StreamError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed || self.frame == self.entries.len() {
            return None;
        }
        let item = self.item();
        self.failed = item.is_err();
        Some(item)
    }
}

/// The first way in which a frame's entry of the index is not what was read of the frame.
fn difference(index: &FrameEntry, seen: &FrameEntry) -> Option<Fault> {
    let values = |entry: &FrameEntry| {
        let FrameEntry { number, offset, bytes, raw_bytes, rays, blocks, totals } = *entry;
        let own = [number.into(), offset, bytes.0, raw_bytes.0, rays, blocks];
        own.into_iter().chain(totals.values())
    };
    let names = ["number", "offset", "bytes", "raw_bytes", "rays", "blocks"]
        .into_iter()
        .chain(Totals::DECLARED.iter().map(|counter| counter.name));
    let mut all = names.zip(values(index)).zip(values(seen));
    all.find_map(|((what, index), found)| {
        (index != found).then_some(Fault::Index { frame: seen.number, what, index, found })
    })
}

/// The file as a row of blocks.
struct Blocks<R> {
    input: R,
    path: PathBuf,
    seed: u32,
    position: u64,
    /// Number of the next block.
    number: u64,
    stored: Vec<u8>,
    /// The payload of the block that was read last.
    raw: Vec<u8>,
}

impl<R: Read + Seek> Blocks<R> {
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

    fn seek(&mut self, position: u64) -> Result<(), StreamError> {
        self.input.seek(SeekFrom::Start(position)).map_err(|source| self.io(source))?;
        self.position = position;
        Ok(())
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), StreamError> {
        self.input.read_exact(bytes).map_err(|source| self.io(source))?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    /// Reads the header of a file of `length` bytes, and learns the seed.
    fn preamble(&mut self, length: u64) -> Result<Header, StreamError> {
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
        let version = u32::from_le_bytes(field(&front, 8));
        if there >= 12 && version != VERSION {
            return Err(StreamError::Version { path: self.path.clone(), found: version, known: VERSION });
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
        serde_json::from_slice(&bytes).map_err(|error| self.corrupt(Place::Header, Fault::Header(error.to_string())))
    }

    /// Reads the index of a file of `length` bytes, of which the preamble has just been read: the entries, and where
    /// the blocks of frames end. The header gets its records.
    fn index(&mut self, header: &mut Header, length: u64) -> Result<(Vec<FrameEntry>, u64), StreamError> {
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
            return Err(self.cut_off(missing));
        }
        if checksum(self.seed, &[&footer[..8]]) != u32::from_le_bytes(field(&footer, 8)) {
            return Err(self.corrupt(Place::Footer, Fault::Checksum));
        }
        let offset = u64::from_le_bytes(field(&footer, 0));
        if !(begin..=footer_at - BLOCK_BYTES as u64).contains(&offset) {
            return Err(self.corrupt(Place::Footer, Fault::Offset { offset }));
        }
        self.seek(offset)?;
        // The block's number is the number of all blocks of frames, which the entries must confirm.
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
        let index = format::index(&self.raw, header.frames.len(), header.static_primitives as usize);
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
    fn read(&mut self, place: Place, end: u64) -> Result<Tag, StreamError> {
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
