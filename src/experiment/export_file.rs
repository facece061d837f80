//! A file that is written piece by piece.

use std::fmt;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::output::OutputFile;

/// The file. All errors name its path.
pub(super) struct ExportFile {
    path: PathBuf,
    file: BufWriter<OutputFile>,
}

impl ExportFile {
    /// Begins the file that is to become `path`.
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let file = OutputFile::create(path).map_err(|error| cannot_write(path, &error))?;
        Ok(Self { path: path.to_owned(), file: BufWriter::new(file) })
    }

    /// Writes a line.
    pub(super) fn line(&mut self, line: fmt::Arguments<'_>) -> io::Result<()> {
        writeln!(self.file, "{line}").map_err(|error| cannot_write(&self.path, &error))
    }

    /// Writes bytes.
    pub(super) fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes).map_err(|error| cannot_write(&self.path, &error))
    }

    /// Puts the file into its place.
    pub(super) fn finish(self) -> io::Result<()> {
        let file = self.file.into_inner().map_err(io::IntoInnerError::into_error);
        file.and_then(OutputFile::finish).map_err(|error| cannot_write(&self.path, &error))
    }
}

fn cannot_write(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("cannot write {}: {error}", path.display()))
}
