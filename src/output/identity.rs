//! Tells whether two paths are the same file.

use std::fs::{File, Metadata};
use std::io;

/// A file's device and inode numbers: the same for all its names, links included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FileId(u64, u64);

impl FileId {
    /// The identity of an existing file; `None` on systems without such numbers.
    #[cfg(unix)]
    pub(super) fn of(metadata: &Metadata) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        Some(Self(metadata.dev(), metadata.ino()))
    }

    #[cfg(not(unix))]
    pub(super) fn of(_: &Metadata) -> Option<Self> {
        None
    }

    /// The device.
    pub(super) fn device(self) -> u64 {
        self.0
    }

    /// The identity of the file behind standard output.
    #[cfg(unix)]
    pub(super) fn of_standard_output() -> Option<Self> {
        use std::os::fd::AsFd;
        let output = io::stdout().as_fd().try_clone_to_owned().ok()?;
        Self::of(&File::from(output).metadata().ok()?)
    }

    #[cfg(not(unix))]
    pub(super) fn of_standard_output() -> Option<Self> {
        None
    }
}
