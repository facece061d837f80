//! Locks on folders and files of results: an advisory lock on a file beside each, released when its holder dies.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use super::links::folder_of;
use super::names::{LOCK_SUFFIX, PREFIX};
use super::registry::{absolute, is_at, live};

/// Attempts to read the name of a lock's holder, and the pause between two attempts. Assumed.
const NAME_ATTEMPTS: u32 = 20;
const NAME_WAIT: Duration = Duration::from_millis(5);

/// Why a lock could not be taken.
#[derive(Debug)]
pub(super) enum LockError {
    /// Another process holds the lock: which one, where, and since when.
    Held(String),
    /// The lock file cannot be made or locked.
    File(io::Error),
}

/// Who else may hold the lock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Holders {
    /// Nobody.
    One,
    /// Others that share it.
    Many,
}

/// A lock that is held until this is dropped.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    file: File,
    holders: Holders,
}

impl Lock {
    /// Locks the file or folder `target`. It need not exist, but its parent must.
    pub(super) fn acquire(target: &Path) -> Result<Self, LockError> {
        Self::acquire_for(target, Holders::One)
    }

    /// As [`Self::acquire`], together with others that share the lock.
    pub(super) fn share(target: &Path) -> Result<Self, LockError> {
        Self::acquire_for(target, Holders::Many)
    }

    fn acquire_for(target: &Path, holders: Holders) -> Result<Self, LockError> {
        let mut name = OsString::from(PREFIX);
        name.push(target.file_name().unwrap_or_default());
        name.push(LOCK_SUFFIX);
        let path = folder_of(target).join(name);
        loop {
            let mut live = live();
            // The holder's name replaces what the file holds.
            if path.is_symlink() {
                let what = format!("{} is a symbolic link: remove it", path.display());
                return Err(LockError::File(io::Error::new(io::ErrorKind::InvalidInput, what)));
            }
            let open = File::options().read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = open.map_err(LockError::File)?;
            let locked = match holders {
                Holders::One => file.try_lock(),
                Holders::Many => file.try_lock_shared(),
            };
            match locked {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    drop(live);
                    return Err(LockError::Held(named(&mut file).unwrap_or_else(|| "another process".to_owned())));
                }
                Err(TryLockError::Error(error)) => {
                    // The file system has no locks, so the file is useless.
                    let _ = fs::remove_file(&path);
                    return Err(LockError::File(error));
                }
            }
            // The earlier holder removes the file when it is done. This process then holds the lock of a removed file,
            // which locks nothing.
            if !is_at(&file, &path).map_err(LockError::File)? {
                continue;
            }
            let told = file.set_len(0).and_then(|()| file.write_all(holder().as_bytes()));
            if let Err(error) = told {
                let _ = fs::remove_file(&path);
                return Err(LockError::File(error));
            }
            // The file of a shared lock stays when a signal ends one of its holders: the others need it.
            if holders == Holders::One {
                live.insert(absolute(&path));
            }
            return Ok(Self { path, file, holders });
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let mut live = live();
        // The last holder removes the file.
        if self.holders == Holders::One || self.file.try_lock().is_ok() {
            let _ = fs::remove_file(&self.path);
        }
        live.remove(&absolute(&self.path));
    }
}

/// The holder's name from the lock file. A holder writes it right after locking: a few attempts suffice.
fn named(file: &mut File) -> Option<String> {
    (0..NAME_ATTEMPTS).find_map(|attempt| {
        if attempt > 0 {
            std::thread::sleep(NAME_WAIT);
        }
        let mut holder = String::new();
        file.rewind().ok()?;
        file.take(4096).read_to_string(&mut holder).ok()?;
        (!holder.is_empty()).then_some(holder)
    })
}

/// The name of this process, for a lock file.
fn holder() -> String {
    #[cfg(unix)]
    let host = rustix::system::uname().nodename().to_string_lossy().into_owned();
    #[cfg(not(unix))]
    let host = "this machine".to_owned();
    let since = humantime::format_rfc3339_seconds(SystemTime::now());
    format!("process {} on {host}, since {since}", std::process::id())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_holder_is_told_of_the_first() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("rep");
        let first = Lock::acquire(&target).unwrap();
        let Err(LockError::Held(holder)) = Lock::acquire(&target) else { panic!("it was locked twice") };
        assert!(holder.starts_with(&format!("process {} on ", std::process::id())), "{holder}");
        assert!(holder.contains(", since 20"), "{holder}");
        let _other = Lock::acquire(&folder.path().join("rep2")).unwrap();
        drop(first);
        assert!(!folder.path().join(".umbrasim-rep.lock").exists());
        Lock::acquire(&target).unwrap();
    }

    /// The holder's name would be written over what the link leads to.
    #[cfg(unix)]
    #[test]
    fn a_link_is_no_lock() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("mine"), "mine").unwrap();
        std::os::unix::fs::symlink("mine", folder.path().join(".umbrasim-rep.lock")).unwrap();
        let Err(LockError::File(error)) = Lock::acquire(&folder.path().join("rep")) else {
            panic!("a link was locked")
        };
        assert!(error.to_string().contains("is a symbolic link"), "{error}");
        assert_eq!(std::fs::read(folder.path().join("mine")).unwrap(), b"mine");
    }

    #[test]
    fn a_holder_that_writes_its_name_late_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(".umbrasim-rep.lock");
        let mut file = File::create(&path).unwrap();
        file.try_lock().unwrap();
        let holder = std::thread::spawn(move || {
            std::thread::sleep(2 * NAME_WAIT);
            file.write_all(b"process 7 on earth").unwrap();
            file
        });
        let Err(LockError::Held(named)) = Lock::acquire(&folder.path().join("rep")) else {
            panic!("it was locked twice")
        };
        assert_eq!(named, "process 7 on earth");
        drop(holder.join().unwrap());
        // A holder that never writes its name is reported as another process.
        let silent = File::create(&path).unwrap();
        silent.try_lock().unwrap();
        let Err(LockError::Held(named)) = Lock::acquire(&folder.path().join("rep")) else {
            panic!("it was locked twice")
        };
        assert_eq!(named, "another process");
    }

    #[test]
    fn a_shared_lock_has_many_holders_and_ends_with_the_last() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("rep");
        let [first, second] = [(); 2].map(|()| Lock::share(&target).unwrap());
        for held in [first, second] {
            assert!(matches!(Lock::acquire(&target), Err(LockError::Held(_))));
            drop(held);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let _alone = Lock::acquire(&target).unwrap();
        assert!(matches!(Lock::share(&target), Err(LockError::Held(_))));
    }

    #[test]
    fn a_dead_holders_file_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(".umbrasim-rep.lock"), "process 1 on nowhere").unwrap();
        drop(Lock::acquire(&folder.path().join("rep")).unwrap());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
