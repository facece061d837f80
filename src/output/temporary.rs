//! Temporary files and folders of this process, all of them registered.
//!
//! Each has an advisory lock until its process ends: [`super::leftovers`] removes those without a lock.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

use tempfile::{NamedTempFile, TempDir};

use super::leftovers;
use super::names::{FILE_SUFFIX, FOLDER_SUFFIX, PREFIX};
use super::registry::{absolute, is_at, live};

/// Locks a file or folder that was just made at `path`. Returns `false` if another process took it for a leftover in
/// the meantime.
fn lock_new(file: &File, path: &Path) -> io::Result<bool> {
    match file.try_lock() {
        // The file system has no locks: no other process can lock the file either, so none removes it.
        Ok(()) | Err(TryLockError::Error(_)) => is_at(file, path),
        Err(TryLockError::WouldBlock) => Ok(false),
    }
}

/// A file that is removed when it is dropped, unless it has been placed.
#[derive(Debug)]
pub(super) struct TemporaryFile(Option<NamedTempFile>);

impl TemporaryFile {
    /// Makes a file in `folder`.
    pub(super) fn create_in(folder: &Path) -> io::Result<Self> {
        leftovers::sweep(folder);
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(FILE_SUFFIX);
        // Temporary files are readable by their owner only; this one gets ordinary permissions.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        loop {
            let mut live = live();
            let file = builder.tempfile_in(folder)?;
            if lock_new(file.as_file(), file.path())? {
                live.insert(absolute(file.path()));
                return Ok(Self(Some(file)));
            }
        }
    }

    /// The open file.
    pub(super) fn file(&self) -> &File {
        self.0.as_ref().expect("it is there until it is placed or dropped").as_file()
    }

    /// Renames the file to `path`, replacing an existing file.
    pub(super) fn place(mut self, path: &Path) -> io::Result<()> {
        let mut live = live();
        let file = self.0.take().expect("it is there until it is placed or dropped");
        let temporary = absolute(file.path());
        // Dropping the error removes a file that cannot be placed.
        let placed = file.persist(path).map(drop).map_err(|failed| failed.error);
        live.remove(&temporary);
        placed
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            let mut live = live();
            live.remove(&absolute(file.path()));
            drop(file);
        }
    }
}

/// A folder that is removed with its content when it is dropped.
#[derive(Debug)]
pub(crate) struct TemporaryFolder {
    dir: Option<TempDir>,
    _locked: Option<File>,
}

impl TemporaryFolder {
    /// Makes a folder in `parent`.
    ///
    /// # Errors
    /// The parent does not exist, or takes no new folder.
    pub(crate) fn create_in(parent: &Path) -> io::Result<Self> {
        leftovers::sweep(parent);
        loop {
            let mut live = live();
            let dir = tempfile::Builder::new().prefix(PREFIX).suffix(FOLDER_SUFFIX).tempdir_in(parent)?;
            // Where folders cannot be opened, they have no locks and are not swept.
            let file = File::open(dir.path()).ok();
            if file.as_ref().map_or(Ok(true), |file| lock_new(file, dir.path()))? {
                live.insert(absolute(dir.path()));
                return Ok(Self { dir: Some(dir), _locked: file });
            }
        }
    }

    /// Makes a folder in the system's folder for temporary files.
    ///
    /// # Errors
    /// The system's folder takes no new folder.
    pub(crate) fn create() -> io::Result<Self> {
        Self::create_in(&std::env::temp_dir())
    }

    /// Its path.
    pub(crate) fn path(&self) -> &Path {
        self.dir.as_ref().expect("it is there until it is dropped").path()
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        if let Some(dir) = self.dir.take() {
            let mut live = live();
            live.remove(&absolute(dir.path()));
            drop(dir);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn what_is_dropped_leaves_nothing_and_is_known_until_then() {
        let folder = tempfile::tempdir().unwrap();
        let file = TemporaryFile::create_in(folder.path()).unwrap();
        let work = TemporaryFolder::create_in(folder.path()).unwrap();
        fs::write(work.path().join("a"), "a").unwrap();
        let known = || live().iter().filter(|path| path.starts_with(folder.path())).count();
        assert_eq!((known(), fs::read_dir(folder.path()).unwrap().count()), (2, 2));
        drop((file, work));
        assert_eq!((known(), fs::read_dir(folder.path()).unwrap().count()), (0, 0));
    }
}
