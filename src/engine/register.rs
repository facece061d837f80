//! The coalescing register in front of a shadow-cache unit: holds the entries read last, and updates that wait to be
//! merged.

use std::collections::VecDeque;

use crate::quantity::Addr;
use crate::stream::Step;

/// What becomes of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kept {
    /// It is merged with a waiting update of the same entry.
    Merged,
    /// It waits in the register.
    Waits,
    /// It waits in the place of the oldest update, given here, which must be performed.
    InPlaceOf(Step),
}

/// The register. Entries are identified by address.
#[derive(Clone, Debug)]
pub(super) struct Register {
    entries: usize,
    read: VecDeque<Addr>,
    waiting: VecDeque<(Addr, Step)>,
}

impl Register {
    /// An empty register.
    pub(super) fn new(entries: usize) -> Self {
        Self { entries, read: VecDeque::new(), waiting: VecDeque::new() }
    }

    /// Whether the machine has one.
    pub(super) fn is_there(&self) -> bool {
        self.entries > 0
    }

    /// Whether the register answers a read of the entry at `addr`.
    pub(super) fn answers(&self, addr: Addr) -> bool {
        self.read.contains(&addr)
    }

    /// Records that the entry at `addr` has been read.
    pub(super) fn was_read(&mut self, addr: Addr) {
        if self.is_there() && !self.answers(addr) {
            if self.read.len() == self.entries {
                self.read.pop_front();
            }
            self.read.push_back(addr);
        }
    }

    /// Takes the update `step` of the entry at `addr`.
    pub(super) fn keep(&mut self, addr: Addr, step: Step) -> Kept {
        if self.waiting.iter().any(|&(other, _)| other == addr) {
            return Kept::Merged;
        }
        let oldest = if self.waiting.len() < self.entries { None } else { self.waiting.pop_front() };
        self.waiting.push_back((addr, step));
        oldest.map_or(Kept::Waits, |(_, step)| Kept::InPlaceOf(step))
    }

    /// Ends a frame: forgets the entries read, and returns the waiting updates, the oldest first.
    pub(super) fn drain(&mut self) -> impl Iterator<Item = Step> + '_ {
        self.read.clear();
        self.waiting.drain(..).map(|(_, step)| step)
    }
}
