//! The list of a folder's own files, and the transfer of all other files to the folder that replaces it.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::error::FolderError;
use super::file::write_whole;

/// Name of the list of own files. A folder that has the list was made by this program.
pub(super) const LIST: &str = ".report-files";
/// The first line of the list.
const TITLE: &str = "The files of this umbrasim report; everything else in the folder stays when it is written again.";

/// Paths of own files, relative to their folder.
pub(super) type Own = BTreeSet<PathBuf>;

/// Reads the list of the folder; `None` if it has none.
pub(super) fn read_list(folder: &Path) -> io::Result<Option<Own>> {
    match fs::read_to_string(folder.join(LIST)) {
        Ok(text) => Ok(Some(text.lines().skip(1).map(PathBuf::from).collect())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Writes the list of all files in the folder into it, and returns the list.
pub(super) fn write_list(folder: &Path) -> io::Result<Own> {
    let mut own = Own::new();
    collect(folder, Path::new(""), &mut own)?;
    let mut text = format!("{TITLE}\n");
    own.iter().for_each(|path| text += &format!("{}\n", path.display()));
    write_whole(&folder.join(LIST), text.as_bytes())?;
    Ok(own)
}

fn collect(folder: &Path, within: &Path, own: &mut Own) -> io::Result<()> {
    for entry in fs::read_dir(folder.join(within))? {
        let entry = entry?;
        let path = within.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            collect(folder, &path, own)?;
        } else if path != Path::new(LIST) {
            own.insert(path);
        }
    }
    Ok(())
}

/// Puts everything in `old` except `own` into `new` as well: makes folders, and links files, so that both folders have
/// them. Nothing in `old` changes.
pub(super) fn carry(old: &Path, new: &Path, own: &Own) -> Result<(), FolderError> {
    each_foreign(old, Path::new(""), own, &mut |within, is_folder| {
        let (from, to) = (old.join(within), new.join(within));
        let failed = |source| FolderError::Write { path: from.clone(), source };
        let there = to.symlink_metadata().is_ok();
        if is_folder && to.is_dir() {
            return Ok(());
        }
        if there {
            return Err(FolderError::Collision { path: from });
        }
        fs::create_dir_all(to.parent().unwrap_or(new)).map_err(failed)?;
        let done = if is_folder { make_like(&from, &to) } else { link(&from, &to) };
        done.map_err(failed)
    })
}

/// Moves what was added to `old` during the replacement, and is not in `new`.
pub(super) fn carry_late(old: &Path, new: &Path, own: &Own) -> Result<(), FolderError> {
    each_foreign(old, Path::new(""), own, &mut |within, is_folder| {
        let (from, to) = (old.join(within), new.join(within));
        if to.symlink_metadata().is_ok() {
            return Ok(());
        }
        let moved = if is_folder { make_like(&from, &to) } else { fs::rename(&from, &to) };
        moved.map_err(|source| FolderError::Write { path: to, source })
    })
}

/// Calls `visit` for each foreign file, and for each folder without own files, before what is in the folder.
fn each_foreign(
    root: &Path,
    within: &Path,
    own: &Own,
    visit: &mut impl FnMut(&Path, bool) -> Result<(), FolderError>,
) -> Result<(), FolderError> {
    let read = |source| FolderError::Read { path: root.join(within), source };
    for entry in fs::read_dir(root.join(within)).map_err(read)? {
        let entry = entry.map_err(read)?;
        let path = within.join(entry.file_name());
        if entry.file_type().map_err(read)?.is_dir() {
            if !own.iter().any(|own| own.starts_with(&path)) {
                visit(&path, true)?;
            }
            each_foreign(root, &path, own, visit)?;
        } else if !own.contains(&path) && path != Path::new(LIST) {
            visit(&path, false)?;
        }
    }
    Ok(())
}

/// Makes a folder with the permissions of another one.
pub(super) fn make_like(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir(to)?;
    fs::set_permissions(to, from.metadata()?.permissions())
}

/// Makes a hard link to a file, or a copy where links are impossible.
fn link(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Err(_) if from.symlink_metadata()?.is_file() => fs::copy(from, to).map(drop),
        done => done,
    }
}
