//! Files that come into their places whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file on its way: bytes go to a temporary file beside `path`, which takes that name in [`NewFile::finish`] only. One
/// that is dropped leaves nothing behind, and what was there before stays.
#[derive(Debug)]
pub struct NewFile {
    file: NamedTempFile,
    path: PathBuf,
}

impl NewFile {
    /// Begins the file that is to become `path`.
    ///
    /// # Errors
    /// The folder is not there, or does not take new files.
    pub fn create(path: &Path) -> io::Result<Self> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            let what = format!("there is no folder {}", folder.display());
            return Err(io::Error::new(io::ErrorKind::NotFound, what));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".umbrasim-").suffix(".part");
        // A temporary file is its owner's alone; this one is to be a file like any other.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        Ok(Self { file: builder.tempfile_in(folder)?, path: path.to_owned() })
    }

    /// Puts the file into its place, in that of an earlier one if there is one. Its bytes are on the disk then.
    ///
    /// # Errors
    /// The disk is full, which may be noticed only now, or `path` cannot be replaced.
    pub fn finish(self) -> io::Result<()> {
        self.file.as_file().sync_all()?;
        self.file.persist(&self.path).map(drop).map_err(|failed| failed.error)
    }
}

/// Writes a file whole.
pub fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = NewFile::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}

impl Write for NewFile {
    // By way of the file itself: the temporary file's own errors name its passing name.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}
