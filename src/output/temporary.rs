//! Temporary files and folders of this process, all of them in the register.
//!
//! Each is locked (an advisory lock, which dies with its holder) as long as its process lives: [`super::leftovers`]
//! removes those that nobody locks.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

use tempfile::{NamedTempFile, TempDir};

use super::leftovers;
use super::names::{FILE_SUFFIX, FOLDER_SUFFIX, PREFIX};
use super::registry::{absolute, is_at, live};

/// Locks a file or folder that was just made at `path`. `false` if another process took it for a dead one's meanwhile.
fn lock_new(file: &File, path: &Path) -> io::Result<bool> {
    match file.try_lock() {
        // A file system without locks: nobody else can lock it either, so nobody takes it for a dead one's.
        Ok(()) | Err(TryLockError::Error(_)) => is_at(file, path),
        Err(TryLockError::WouldBlock) => Ok(false),
    }
}

/// A file that is removed when it is dropped, unless it was placed.
#[derive(Debug)]
pub(super) struct TemporaryFile(Option<NamedTempFile>);

impl TemporaryFile {
    /// A new file in `folder`.
    pub(super) fn create_in(folder: &Path) -> io::Result<Self> {
        leftovers::sweep(folder);
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(FILE_SUFFIX);
        // A temporary file is its owner's alone; this one is to be a file like any other.
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

    /// Gives the file its name, in place of an earlier one.
    pub(super) fn place(mut self, path: &Path) -> io::Result<()> {
        let mut live = live();
        let file = self.0.take().expect("it is there until it is placed or dropped");
        let temporary = absolute(file.path());
        // A file that cannot be placed is removed with the error.
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

/// A folder that is removed with all that is in it when it is dropped.
#[derive(Debug)]
pub(crate) struct TemporaryFolder {
    dir: Option<TempDir>,
    _locked: Option<File>,
}

impl TemporaryFolder {
    /// A new folder in `parent`.
    ///
    /// # Errors
    /// The parent is not there, or takes no new folder.
    pub(crate) fn create_in(parent: &Path) -> io::Result<Self> {
        leftovers::sweep(parent);
        loop {
            let mut live = live();
            let dir = tempfile::Builder::new().prefix(PREFIX).suffix(FOLDER_SUFFIX).tempdir_in(parent)?;
            // Where folders cannot be opened, there are no locks on them, and no sweep of them.
            let file = File::open(dir.path()).ok();
            if file.as_ref().map_or(Ok(true), |file| lock_new(file, dir.path()))? {
                live.insert(absolute(dir.path()));
                return Ok(Self { dir: Some(dir), _locked: file });
            }
        }
    }

    /// A new folder in the system's folder of temporary files.
    ///
    /// # Errors
    /// That one takes no new folder.
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
