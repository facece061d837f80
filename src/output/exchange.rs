//! Replaces a folder by another one, in one step where the file system can.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::links::folder_of;
use super::names::{EARLIER, NEW};

/// Moves the folder [`NEW`] of the temporary folder `work`, which is beside `target`, to `target`. An earlier folder
/// is afterwards [`NEW`] in `work`, or in [`EARLIER`].
///
/// # Errors
/// The target cannot be replaced, and is unchanged.
pub(super) fn exchange(work: &Path, target: &Path) -> io::Result<()> {
    let new = work.join(NEW);
    if target.symlink_metadata().is_err() {
        return fs::rename(new, target);
    }
    match exchange_at_once(work, target) {
        Err(error) if error.kind() == io::ErrorKind::Unsupported => {}
        done => return done,
    }
    // Two steps: after a kill between them, the process that sweeps the temporary folder puts the earlier folder back.
    let name = target.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let earlier = work.join(EARLIER);
    fs::create_dir(&earlier)?;
    let earlier = earlier.join(name);
    fs::rename(target, &earlier)?;
    fs::rename(new, target).inspect_err(|_| {
        // The first error is returned; the earlier folder goes back if possible.
        let _ = fs::rename(&earlier, target);
    })
}

/// Exchanges the folders in one system call, which not all file systems have.
#[cfg(target_os = "linux")]
fn exchange_at_once(work: &Path, target: &Path) -> io::Result<()> {
    use rustix::fs::{RenameFlags, renameat_with};
    use rustix::io::Errno;

    let (Some(work), Some(name)) = (work.file_name(), target.file_name()) else {
        return Err(io::ErrorKind::InvalidInput.into());
    };
    let folder = File::open(folder_of(target))?;
    let new = Path::new(work).join(NEW);
    renameat_with(&folder, &new, &folder, name, RenameFlags::EXCHANGE).map_err(|error| match error {
        Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP => io::ErrorKind::Unsupported.into(),
        error => error.into(),
    })
}

#[cfg(not(target_os = "linux"))]
fn exchange_at_once(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// The path of the replaced folder in `work`.
pub(super) fn replaced(work: &Path, target: &Path) -> PathBuf {
    let earlier = work.join(EARLIER).join(target.file_name().unwrap_or_default());
    if earlier.is_dir() { earlier } else { work.join(NEW) }
}
