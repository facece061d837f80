//! Reads ray stream files.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;
use std::sync::Arc;

use super::blocks::{Blocks, difference};
use super::check::Checker;
use super::error::{Place, StreamError};
use super::fault::Fault;
use super::format::{FrameEntry, Tag};
use super::header::Header;
use super::item::Item;
use super::{check, columns, format};
use crate::quantity::Bytes;

/// An iterator over a stream's items, from the stream's start or from the frame of [`StreamReader::seek_frame`]. It
/// ends after an error.
///
/// Opening reads and checks the header and the index. Every block is checked against its checksum, every item against
/// the rules of streams, every frame against its totals and its entry of the index. Memory is bounded by
/// `format::RAW_LIMIT` and by the file's length, whatever the file says.
pub struct StreamReader<R = BufReader<File>> {
    blocks: Blocks<R>,
    checker: Checker,
    entries: Vec<FrameEntry>,
    /// Bytes of the file.
    length: u64,
    /// Where the blocks of frames end: the index's offset.
    end: u64,
    /// Index in `entries` of the frame that is being read, or of the next one.
    frame: usize,
    /// The frame's index entry, computed from what was read.
    seen: FrameEntry,
    failed: bool,
}

impl StreamReader {
    /// Opens the file `path`.
    ///
    /// # Errors
    /// The file cannot be read, or is no stream of a known version.
    pub fn open(path: &Path) -> Result<Self, StreamError> {
        let failed = |source| StreamError::Io { path: path.to_owned(), doing: "read", source };
        let input = crate::input::open(path).map_err(failed)?;
        Self::new(BufReader::new(input), path)
    }
}

impl<R: Read + Seek> StreamReader<R> {
    /// Opens a stream that fills `input`; errors name `path`.
    ///
    /// # Errors
    /// As [`StreamReader::open`].
    pub fn new(input: R, path: &Path) -> Result<Self, StreamError> {
        let mut blocks = Blocks::new(input, path);
        let length = blocks.length()?;
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

    /// The version of the file's layout.
    pub fn version(&self) -> u32 {
        self.blocks.version.number()
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
    ///
    /// # Errors
    /// The file cannot be read.
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
        let (payload, version) = (&self.blocks.raw, self.blocks.version);
        let item = match tag {
            Tag::Frame => format::frame(payload).map(Item::Frame),
            Tag::Rays => columns::chunk(payload, version).map(|chunk| Item::Rays(Arc::new(chunk))),
            Tag::End => {
                format::end(payload, version).map(|(policy, totals)| Item::End { policy: Arc::new(policy), totals })
            }
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
