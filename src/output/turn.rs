//! Turns at files that several processes would make: one makes a file, the others wait for it or do something else.

use std::path::Path;

use super::lock::{Lock, LockError};

/// The turn to make a file, until this is dropped.
#[derive(Debug)]
pub(crate) struct Turn {
    _lock: Option<Lock>,
}

impl Turn {
    /// Takes the turn to make the file `target`; none while another process has the turn. Where no lock can be had
    /// everybody has the turn: the same file may be made twice, and what is wrong there is told when the file is
    /// written.
    pub(crate) fn take(target: &Path) -> Option<Self> {
        match Lock::acquire(target) {
            Ok(lock) => Some(Self { _lock: Some(lock) }),
            Err(LockError::Held(_)) => None,
            Err(LockError::File(_)) => Some(Self { _lock: None }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_has_the_turn() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let turn = Turn::take(&target).unwrap();
        assert!(Turn::take(&target).is_none());
        assert!(Turn::take(&folder.path().join("b")).is_some());
        drop(turn);
        assert!(Turn::take(&target).is_some());
        assert!(Turn::take(&folder.path().join("no/a")).is_some());
    }
}
