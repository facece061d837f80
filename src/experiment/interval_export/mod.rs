//! Writes a machine's counters at a fixed interval of cycles, as CSV.

#[cfg(test)]
mod tests;

use std::io;
use std::path::Path;

use super::export_file::ExportFile;
use crate::replay::Observer;
use crate::report::run::{CountedColumn, counted_columns};
use crate::stats::{FrameStats, MachineStats};
use crate::stream::Header;

/// Writes a row per interval. An interval ends with its frame, so that the rows of a frame sum to the frame's counts.
pub(crate) struct IntervalExport {
    interval: u64,
    /// The warm-up frames.
    warmup: Vec<u32>,
    /// The counts up to the last row.
    before: MachineStats,
    /// The columns, known from the first row on: they depend on the machine's parts.
    columns: Vec<CountedColumn>,
    file: ExportFile,
}

impl IntervalExport {
    /// Begins the file, with a row every `interval` cycles.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn create(header: &Header, interval: u64, path: &Path) -> io::Result<Self> {
        let (warmup, file) = (header.warmup.clone(), ExportFile::create(path)?);
        Ok(Self { interval, warmup, before: MachineStats::default(), columns: Vec::new(), file })
    }

    /// Puts the file into its place.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn finish(self) -> io::Result<()> {
        self.file.finish()
    }

    fn row(&mut self, begin: u64, row: &FrameStats) -> io::Result<()> {
        if self.columns.is_empty() {
            self.columns = counted_columns(row);
            let counted = self.columns.iter().map(|(name, _)| name.as_str());
            let head: Vec<&str> = ["frame", "warmup", "begin", "cycles", "rays"].into_iter().chain(counted).collect();
            self.file.line(format_args!("{}", head.join(",")))?;
        }
        let counted: Vec<String> = self.columns.iter().map(|(_, text)| text(row)).collect();
        let FrameStats { frame, warmup, cycles, rays, .. } = row;
        self.file.line(format_args!("{frame},{},{begin},{cycles},{rays},{}", u8::from(*warmup), counted.join(",")))
    }
}

impl Observer for IntervalExport {
    fn interval(&self) -> Option<u64> {
        Some(self.interval)
    }

    fn counted(&mut self, frame: u32, stats: MachineStats) -> io::Result<()> {
        let mut own = stats.since(&self.before);
        // Before rays move there is no entry `fifos`, but its column is needed.
        own.bytes.entry("fifos".into()).or_default();
        let row = own.as_frame(frame, self.warmup.contains(&frame), 0);
        let begin = self.before.cycles.0;
        self.before = stats;
        self.row(begin, &row)
    }
}
