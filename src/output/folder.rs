//! Folders of results.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::carry::{self, Own};
use super::error::FolderError;
use super::exchange;
use super::identity::FileId;
use super::leftovers;
use super::links::{folder_of, follow};
use super::lock::{Lock, LockError};
use super::names::NEW;
use super::temporary::TemporaryFolder;

/// The file that marks a folder without a list of own files as a report.
const SUMMARY: &str = "summary.json";

/// Time after which a process that wants to share a folder gives up on its writer. Assumed.
const PATIENCE: Duration = Duration::from_secs(20);
/// Pause between attempts to share a folder. Assumed.
const PAUSE: Duration = Duration::from_millis(20);

/// A folder of results that this process has locked, from before the work to its end.
#[derive(Debug)]
pub(crate) struct ResultsFolder {
    /// The path, as the user named it.
    path: PathBuf,
    /// The path, links followed.
    target: PathBuf,
    _lock: Lock,
    /// Dropped last, after the lock file is removed.
    _parents: Parents,
}

impl ResultsFolder {
    /// Claims the folder `path` before the work begins. The path may be free, an empty folder, or a folder of results.
    ///
    /// # Errors
    /// Something else is at the path, another process writes there, or nothing can be written there.
    pub(crate) fn claim(path: &Path) -> Result<Self, FolderError> {
        let write = |source| FolderError::Write { path: path.into(), source };
        check(path, &target_of(path).map_err(write)?)?;
        Self::lock(path)
    }

    /// Locks the folder `path`, and then checks its content.
    fn lock(path: &Path) -> Result<Self, FolderError> {
        let write = |source| FolderError::Write { path: path.into(), source };
        let target = target_of(path).map_err(write)?;
        let parent = folder_of(&target);
        let parents = Parents::make(parent).map_err(write)?;
        leftovers::sweep(parent);
        let lock = Lock::acquire(&target).map_err(|error| match error {
            LockError::Held(holder) => FolderError::Busy { path: path.into(), holder },
            LockError::File(source) => write(source),
        })?;
        // A process that died before it wrote the folder's list left at most a part of the list.
        leftovers::sweep(&target);
        check(path, &target)?;
        Ok(Self { path: path.into(), target, _lock: lock, _parents: parents })
    }

    /// Shares the folder `path` with other processes that keep results in it one by one; makes the folder if it does
    /// not exist. While it is shared, nobody can [`claim`](Self::claim) it, so nobody can [`replace`](Self::replace)
    /// its files.
    ///
    /// # Errors
    /// As [`Self::claim`], or another process writes there alone for longer than `PATIENCE`.
    pub(crate) fn share(path: &Path) -> Result<SharedFolder, FolderError> {
        let write = |source| FolderError::Write { path: path.into(), source };
        let begin = Instant::now();
        loop {
            let target = target_of(path).map_err(write)?;
            let busy = if matches!(carry::read_list(&target), Ok(Some(_))) {
                check(path, &target)?;
                match Lock::share(&target) {
                    Ok(lock) => return Ok(SharedFolder { path: path.into(), _lock: lock }),
                    Err(LockError::Held(holder)) => FolderError::Busy { path: path.into(), holder },
                    Err(LockError::File(source)) => return Err(write(source)),
                }
            } else {
                // The list names the files that exist when it is written, so nobody else may write meanwhile.
                match Self::lock(path).and_then(|alone| alone.make()) {
                    Ok(()) => continue,
                    Err(busy @ FolderError::Busy { .. }) => busy,
                    Err(error) => return Err(error),
                }
            };
            if begin.elapsed() > PATIENCE {
                return Err(busy);
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// The folder, as the user named it.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the folder, if it does not exist yet, for results that are kept one by one.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub(crate) fn make(&self) -> Result<(), FolderError> {
        let write = |source| FolderError::Write { path: self.path.clone(), source };
        if carry::read_list(&self.target).map_err(write)?.is_none() {
            fs::create_dir_all(&self.target).map_err(write)?;
            carry::write_list(&self.target).map_err(write)?;
        }
        Ok(())
    }

    /// Replaces the folder's own files by those that `fill` makes in a new folder: all of them, or none on an error.
    /// All other files stay.
    ///
    /// # Errors
    /// Errors of `fill`; or the new files cannot be put at their path, and are kept beside it.
    pub(crate) fn replace<E: From<FolderError>>(&self, fill: impl FnOnce(&Path) -> Result<(), E>) -> Result<(), E> {
        let target = self.target.as_path();
        let write = |source| FolderError::Write { path: self.path.clone(), source };
        let work = TemporaryFolder::create_in(folder_of(target)).map_err(write)?;
        let new = work.path().join(NEW);
        let there = target.is_dir();
        let made = if there { carry::make_like(target, &new) } else { fs::create_dir(&new) };
        made.map_err(write)?;
        fill(&new)?;
        let added = carry::write_list(&new).map_err(write)?;
        self.place(&work, &added).map_err(|error| self.elsewhere(&new, error).into())
    }

    fn place(&self, work: &TemporaryFolder, added: &Own) -> Result<(), FolderError> {
        let target = self.target.as_path();
        let there = target.is_dir();
        let read = |source| FolderError::Read { path: self.path.clone(), source };
        // A report without a list: only files that the new report also has are replaced.
        let own = carry::read_list(target).map_err(read)?.unwrap_or_else(|| added.clone());
        if there {
            carry::carry(target, &work.path().join(NEW), &own)?;
        }
        let write = |source| FolderError::Write { path: self.path.clone(), source };
        exchange::exchange(work.path(), target).map_err(write)?;
        if there {
            carry::carry_late(&exchange::replaced(work.path(), target), target, &own)?;
        }
        Ok(())
    }

    /// Keeps complete results that cannot be put at their path under another name.
    fn elsewhere(&self, new: &Path, error: FolderError) -> FolderError {
        let name = self.target.file_name().unwrap_or_default();
        let beside = (1..1000).map(|number| {
            let mut name = name.to_owned();
            name.push(format!("-{number}"));
            self.target.with_file_name(name)
        });
        for path in beside {
            if path.symlink_metadata().is_err() && fs::rename(new, &path).is_ok() {
                return FolderError::Elsewhere { path, source: Box::new(error) };
            }
        }
        error
    }
}

/// A folder of results that several processes share; each keeps results in it one by one.
#[derive(Debug)]
pub(crate) struct SharedFolder {
    path: PathBuf,
    _lock: Lock,
}

impl SharedFolder {
    /// The folder, as the user named it.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// The path of a folder, links followed.
fn target_of(path: &Path) -> io::Result<PathBuf> {
    let target = follow(path)?;
    // `.` and `..` have no name of their own.
    if target.file_name().is_none() { target.canonicalize() } else { Ok(target) }
}

/// Checks whether results can be put at `target`.
fn check(path: &Path, target: &Path) -> Result<(), FolderError> {
    let foreign = || Err(FolderError::Foreign { path: path.into() });
    let read = |source| FolderError::Read { path: path.into(), source };
    let entries = match fs::read_dir(target) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => return foreign(),
        Err(source) => return Err(read(source)),
        Ok(entries) => entries,
    };
    let real = target.canonicalize().map_err(read)?;
    if std::env::current_dir().is_ok_and(|current| current.starts_with(&real)) {
        return Err(FolderError::Current { path: path.into() });
    }
    if is_mounted(&real).map_err(read)? {
        return Err(FolderError::Mounted { path: path.into() });
    }
    let is_ours = || Ok(carry::read_list(target)?.is_some() || has_summary(target));
    let is_leftover = |entry: io::Result<fs::DirEntry>| entry.is_ok_and(|it| leftovers::is_leftover(&it.file_name()));
    if entries.into_iter().all(is_leftover) || is_ours().map_err(read)? { Ok(()) } else { foreign() }
}

/// Whether `target` has the summary of a report, of any version.
fn has_summary(target: &Path) -> bool {
    let summary = fs::read(target.join(SUMMARY)).ok().and_then(|text| serde_json::from_slice(&text).ok());
    summary.is_some_and(|summary: serde_json::Value| summary.get("schema").and(summary.get("policies")).is_some())
}

/// Whether a folder is on another file system than its parent.
fn is_mounted(folder: &Path) -> io::Result<bool> {
    let device = |path: &Path| Ok::<_, io::Error>(FileId::of(&path.metadata()?).map(FileId::device));
    folder.parent().map_or(Ok(true), |parent| Ok(device(folder)? != device(parent)?))
}

/// Folders made to hold a folder of results, removed at the end if they are still empty.
#[derive(Debug, Default)]
struct Parents(Vec<PathBuf>);

impl Parents {
    fn make(parent: &Path) -> io::Result<Self> {
        let missing = parent.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        let made = Self(missing.map(Path::to_owned).collect());
        fs::create_dir_all(parent)?;
        Ok(made)
    }
}

impl Drop for Parents {
    fn drop(&mut self) {
        // From the innermost outwards; a folder that is not empty stays.
        self.0.iter().all(|folder| fs::remove_dir(folder).is_ok());
    }
}
