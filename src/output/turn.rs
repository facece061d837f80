//! Turns to make a file that several processes need: one makes it, the others wait or do something else.

use std::path::Path;

use super::lock::{Lock, LockError};

/// The turn to make a file; ends when it is dropped.
#[derive(Debug)]
pub(crate) struct Turn {
    _lock: Option<Lock>,
}

impl Turn {
    /// Takes the turn to make the file `target`; `None` while another process has the turn. Where locks are
    /// impossible, every process gets the turn: a file may be made twice, and any error shows when the file is
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
