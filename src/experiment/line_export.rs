//! Writes the line addresses that a cache is asked for, for cache simulators.

use std::io;
use std::path::Path;

use super::export_file::ExportFile;
use crate::machine::{MachineSpec, SpecError};
use crate::replay::LineStream;
use crate::stream::{Header, Item};

/// Writes the line stream of an L1 in Dinero's format: `0 ADDRESS` for a read, `1 ADDRESS` for a write, in
/// hexadecimal.
pub(crate) struct LineExport {
    lines: LineStream,
    line_bytes: u64,
    file: ExportFile,
    failed: Option<io::Error>,
}

/// Why lines cannot be exported.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LineExportError {
    /// The machine has no such cache.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] io::Error),
}

impl LineExport {
    /// Begins the file, for the L1s that have the name `cache` in reports.
    ///
    /// # Errors
    /// There is no such cache, or the file cannot be written.
    pub(crate) fn create(
        machine: &MachineSpec,
        header: &Header,
        cache: &str,
        path: &Path,
    ) -> Result<Self, LineExportError> {
        let lines = LineStream::new(machine, header, cache)?;
        let file = ExportFile::create(path)?;
        Ok(Self { lines, line_bytes: machine.line_bytes.get(), file, failed: None })
    }

    /// Writes the lines of the stream's next item. [`LineExport::finish`] returns any error.
    pub(crate) fn item(&mut self, item: &Item) {
        let Self { lines, line_bytes, file, failed } = self;
        lines.item(item, |line, write| {
            if failed.is_none() {
                *failed = file.line(format_args!("{} {:x}", u8::from(write), line.0 * *line_bytes)).err();
            }
        });
    }

    /// Puts the file into its place.
    pub(crate) fn finish(self) -> io::Result<()> {
        self.failed.map_or(Ok(()), Err)?;
        self.file.finish()
    }
}
