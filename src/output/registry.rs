//! Registers all temporary files and folders of this process, so that they can be removed however it ends.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::identity::FileId;

/// Absolute paths of all temporary files and folders of this process.
static LIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Locks the register. Code that creates, places or removes a temporary path holds this lock meanwhile.
pub(super) fn live() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    LIVE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files and folders, and ends the process. No other thread can create or place one meanwhile.
pub(super) fn remove_all_and_exit(status: i32) -> ! {
    let live = live();
    for path in live.iter() {
        remove(path);
    }
    std::process::exit(status)
}

/// Removes a file or a folder with all that is in it.
pub(super) fn remove(path: &Path) {
    // Another thread may still write into the folder: a few attempts also remove its new files.
    for _ in 0..4 {
        let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        match removed {
            Err(error) if error.kind() == io::ErrorKind::DirectoryNotEmpty => {}
            _ => return,
        }
    }
}

/// Makes the path absolute, since the current folder may change.
pub(super) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Whether the open `file` is the one at `path`.
pub(super) fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    match path.symlink_metadata() {
        Ok(there) => Ok(FileId::of(&there) == FileId::of(&file.metadata()?)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}
