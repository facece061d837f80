//! Writes ray stream files.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::check::Checker;
use super::columns::{chunk_len, put_chunk};
use super::error::{Place, StreamError};
use super::format::{
    BLOCK_BYTES, BlockHeader, END_MAGIC, FOOTER_BYTES, FrameEntry, HEADER_LIMIT, MAGIC, PREAMBLE_BYTES, RAW_LIMIT, Tag,
    checksum, end_len, index_len, put_end, put_frame, put_index,
};
use super::header::Header;
use super::item::{FrameInfo, Item};
use super::version::Version;
use super::violation::Violation;
use crate::json;
use crate::output::OutputFile;
use crate::quantity::Bytes;
use lz4_flex::block::{compress_into, get_maximum_output_size};

/// Writes a stream item by item, each checked against the rules of streams first. It holds one block in memory at a
/// time.
///
/// `StreamWriter::create` writes an `OutputFile`, which appears only after `StreamWriter::finish`: a dropped or failed
/// writer leaves nothing behind.
pub struct StreamWriter<W = OutputFile> {
    output: W,
    /// The target, for errors.
    path: PathBuf,
    seed: u32,
    checker: Checker,
    entries: Vec<FrameEntry>,
    /// Bytes written so far.
    position: u64,
    /// Blocks written so far.
    blocks: u64,
    /// Whether an item could not be written: the file can no longer be completed.
    failed: bool,
    raw: Vec<u8>,
    block: Vec<u8>,
}

impl StreamWriter {
    /// Begins a stream that becomes the file `path`, whose folder must exist. A file of that name is replaced when the
    /// stream is finished.
    ///
    /// # Errors
    /// The file cannot be made, or the header breaks a rule of streams.
    pub fn create(path: &Path, header: &Header) -> Result<Self, StreamError> {
        let output = OutputFile::create(path);
        let output = output.map_err(|source| StreamError::Io { path: path.to_owned(), doing: "create", source })?;
        Self::new(output, path, header)
    }

    /// Completes the stream: all frames of the header must have been written. After a return without error the file has
    /// its name, and its bytes are on the disk.
    ///
    /// # Errors
    /// The stream is not complete, or the disk is full.
    pub fn finish(self) -> Result<(), StreamError> {
        let path = self.path.clone();
        self.complete()?.finish().map_err(|source| StreamError::Io { path, doing: "write", source })
    }
}

impl<W: Write> StreamWriter<W> {
    /// Begins a stream to `output`; errors name `path`.
    ///
    /// # Errors
    /// As [`StreamWriter::create`].
    pub fn new(output: W, path: &Path, header: &Header) -> Result<Self, StreamError> {
        let invalid = |violation| StreamError::Invalid { path: path.to_owned(), place: Place::Header, violation };
        let checker = Checker::new(header).map_err(invalid)?;
        // Serialising plain data to memory cannot fail; an error is reported all the same.
        let text = json::line(header).map_err(|error| StreamError::Io {
            path: path.to_owned(),
            doing: "write the header of",
            source: error.into(),
        })?;
        let limits = [
            ("a header", text.len(), HEADER_LIMIT),
            ("an index", index_len(header.frames.len(), header.records.len(), Version::CURRENT), RAW_LIMIT),
        ];
        for (what, found, limit) in limits {
            if found > limit {
                return Err(invalid(Violation::TooLarge { what, found: found as u64, limit: limit as u64 }));
            }
        }
        let mut preamble = Vec::with_capacity(PREAMBLE_BYTES + text.len());
        preamble.extend(MAGIC);
        preamble.extend(Version::CURRENT.number().to_le_bytes());
        preamble.extend((text.len() as u32).to_le_bytes());
        let seed = checksum(0, &[&preamble, text.as_bytes()]);
        preamble.extend(seed.to_le_bytes());
        preamble.extend(text.as_bytes());
        let mut writer = Self {
            output,
            path: path.to_owned(),
            seed,
            checker,
            entries: Vec::new(),
            position: 0,
            blocks: 0,
            failed: false,
            raw: Vec::new(),
            block: Vec::new(),
        };
        writer.put(&preamble)?;
        Ok(writer)
    }

    /// Writes the next item. After an error, nothing more can be written.
    ///
    /// # Errors
    /// The item breaks a rule of streams, `output` takes no more, or there was an error before.
    pub fn write(&mut self, item: &Item) -> Result<(), StreamError> {
        if self.failed {
            return Err(StreamError::Failed { path: self.path.clone() });
        }
        let written = self.item(item);
        self.failed = written.is_err();
        written
    }

    /// Completes the stream and returns the output.
    ///
    /// # Errors
    /// The stream is not complete, or `output` takes no more.
    pub fn complete(mut self) -> Result<W, StreamError> {
        if self.failed {
            return Err(StreamError::Failed { path: self.path });
        }
        self.checker.finish().map_err(|violation| self.invalid(violation))?;
        let offset = self.position.to_le_bytes();
        self.raw.clear();
        put_index(&self.entries, &self.checker.header().records, &mut self.raw);
        self.put_block(Tag::Index)?;
        let mut footer = Vec::with_capacity(FOOTER_BYTES);
        footer.extend(offset);
        footer.extend(checksum(self.seed, &[&offset]).to_le_bytes());
        footer.extend(END_MAGIC);
        self.put(&footer)?;
        let flushed = self.output.flush();
        flushed.map_err(|source| StreamError::Io { path: self.path.clone(), doing: "write", source })?;
        Ok(self.output)
    }

    fn item(&mut self, item: &Item) -> Result<(), StreamError> {
        self.checker.check(item).map_err(|violation| self.invalid(violation))?;
        match item {
            Item::Frame(info) => {
                let FrameInfo { number, .. } = *info;
                self.entries.push(FrameEntry { number, offset: self.position, ..FrameEntry::default() });
                self.raw.clear();
                put_frame(info, &mut self.raw);
                self.put_block(Tag::Frame)?;
            }
            Item::Rays(chunk) => {
                self.fits("a chunk", chunk_len(chunk))?;
                self.raw.clear();
                put_chunk(chunk, &mut self.raw);
                self.put_block(Tag::Rays)?;
                self.entry(|entry| entry.rays += chunk.len() as u64);
            }
            Item::End { policy, totals } => {
                self.fits("a frame's end", end_len(policy))?;
                self.raw.clear();
                put_end(policy, totals, &mut self.raw);
                self.put_block(Tag::End)?;
                self.entry(|entry| entry.totals = *totals);
            }
        }
        Ok(())
    }

    fn fits(&self, what: &'static str, bytes: usize) -> Result<(), StreamError> {
        if bytes <= RAW_LIMIT {
            return Ok(());
        }
        Err(self.invalid(Violation::TooLarge { what, found: bytes as u64, limit: RAW_LIMIT as u64 }))
    }

    /// Compresses `self.raw` and writes it as a block.
    fn put_block(&mut self, tag: Tag) -> Result<(), StreamError> {
        let mut block = std::mem::take(&mut self.block);
        let room = BLOCK_BYTES + get_maximum_output_size(self.raw.len());
        block.resize(block.len().max(room), 0);
        let compressed = compress_into(&self.raw, &mut block[BLOCK_BYTES..]);
        let stored = compressed.map_err(|error| StreamError::Io {
            path: self.path.clone(),
            doing: "compress a block of",
            source: std::io::Error::other(error),
        })?;
        let header = BlockHeader { tag, number: self.blocks, raw: self.raw.len(), stored };
        let (front, payload) = block[..BLOCK_BYTES + stored].split_at_mut(BLOCK_BYTES);
        front.copy_from_slice(&header.encode(self.seed, payload));
        self.put(&block[..BLOCK_BYTES + stored])?;
        self.block = block;
        self.blocks += 1;
        if tag != Tag::Index {
            let raw = self.raw.len() as u64;
            self.entry(|entry| {
                entry.bytes += Bytes((BLOCK_BYTES + stored) as u64);
                entry.raw_bytes += Bytes(raw);
                entry.blocks += 1;
            });
        }
        Ok(())
    }

    /// Changes the index entry of the frame that is being written.
    fn entry(&mut self, change: impl FnOnce(&mut FrameEntry)) {
        if let Some(entry) = self.entries.last_mut() {
            change(entry);
        }
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), StreamError> {
        let written = self.output.write_all(bytes);
        written.map_err(|source| StreamError::Io { path: self.path.clone(), doing: "write", source })?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    fn invalid(&self, violation: Violation) -> StreamError {
        let place = Place::Block { frame: self.checker.frame(), block: self.blocks };
        StreamError::Invalid { path: self.path.clone(), place, violation }
    }
}
