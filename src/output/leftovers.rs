//! Removes what dead processes left in a folder.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::names::{EARLIER, FILE_SUFFIX, FOLDER_SUFFIX, LOCK_SUFFIX, PREFIX};
use super::registry::is_at;

/// Folders that this process has swept.
static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes temporary files and folders of dead processes from `folder`, once per process. Those of living processes
/// are locked, and stay. Nothing depends on its success.
pub(crate) fn sweep(folder: &Path) {
    let Ok(real) = folder.canonicalize() else { return };
    if SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(real) {
        sweep_now(folder);
    }
}

fn sweep_now(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Ok(kind) = entry.file_type() else { continue };
        let is = |suffix: &str| is_temporary(&name, suffix);
        let is_file = kind.is_file() && (is(FILE_SUFFIX) || is(LOCK_SUFFIX));
        if is_file || kind.is_dir() && is(FOLDER_SUFFIX) {
            let path = entry.path();
            let Ok(file) = File::open(&path) else { continue };
            // The lock is held during the removal: a process that has just made the file sees that it is gone.
            if file.try_lock().is_ok() && is_at(&file, &path).unwrap_or(false) {
                remove(&path, folder, is_file);
            }
        }
    }
}

fn remove(path: &Path, folder: &Path, is_file: bool) {
    // If the removal fails, the next process tries again.
    if is_file {
        let _ = fs::remove_file(path);
    } else if put_back(path, folder) {
        let _ = fs::remove_dir_all(path);
    }
}

/// Puts back a folder that a dead process had moved out of its place in `folder`. Returns whether `work` can then be
/// removed.
fn put_back(work: &Path, folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(work.join(EARLIER)) else { return true };
    entries.flatten().all(|entry| {
        let place = folder.join(entry.file_name());
        place.symlink_metadata().is_ok() || fs::rename(entry.path(), place).is_ok()
    })
}

/// Whether a name is that of a temporary file or folder, or of a lock.
pub(super) fn is_leftover(name: &OsStr) -> bool {
    [FILE_SUFFIX, FOLDER_SUFFIX, LOCK_SUFFIX].iter().any(|suffix| is_temporary(name, suffix))
}

fn is_temporary(name: &OsStr, suffix: &str) -> bool {
    let name = name.as_encoded_bytes();
    name.starts_with(PREFIX.as_bytes()) && name.ends_with(suffix.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::super::temporary::{TemporaryFile, TemporaryFolder};
    use super::*;

    #[test]
    fn what_is_dead_goes_and_what_lives_or_is_foreign_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for dead in [".umbrasim-a.part", ".umbrasim-rep.lock", "a.part", ".umbrasim-notes"] {
            fs::write(at(dead), "x").unwrap();
        }
        fs::create_dir_all(at(".umbrasim-b.work/new/plots")).unwrap();
        // A report that a process moved out of its place before it died.
        fs::create_dir_all(at(".umbrasim-c.work/earlier/rep")).unwrap();
        fs::write(at(".umbrasim-c.work/earlier/rep/index.html"), "page").unwrap();
        let live = TemporaryFile::create_in(at("").as_path()).unwrap();
        let work = TemporaryFolder::create_in(at("").as_path()).unwrap();
        sweep_now(folder.path());
        let mut left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        let name = |path: &Path| path.file_name().unwrap().to_owned();
        let mut expected = vec![".umbrasim-notes".into(), "a.part".into(), "rep".into(), name(work.path())];
        expected
            .extend(left.iter().filter(|name| name.to_str().unwrap().ends_with(".part") && *name != "a.part").cloned());
        expected.sort();
        assert_eq!(left, expected);
        assert_eq!(left.len(), 5);
        assert_eq!(fs::read_to_string(at("rep/index.html")).unwrap(), "page");
        drop(live);
    }
}
