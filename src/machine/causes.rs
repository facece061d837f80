//! Why each cycle of a unit went as it did, kept by intervals: a part that is not looked at does not change.

use crate::stats::Cause;

/// A unit's cycles by cause.
#[derive(Clone, Copy, Debug)]
pub struct Causes {
    totals: [u64; Cause::ALL.len()],
    /// The cause of the cycles from `from` on, until something happens.
    idle: Cause,
    from: u64,
}

impl Default for Causes {
    fn default() -> Self {
        Self { totals: [0; Cause::ALL.len()], idle: Cause::Starved, from: 0 }
    }
}

impl Causes {
    /// Cycle `now` has passed: the unit began an operation (`busy`) or not, and until something happens `idle` is the cause.
    pub fn cycle(&mut self, now: u64, busy: bool, idle: Cause) {
        self.totals[self.idle as usize] += now - self.from;
        self.totals[if busy { Cause::Busy } else { idle } as usize] += 1;
        (self.idle, self.from) = (idle, now + 1);
    }

    /// Cycles in which an operation began.
    pub fn busy(&self) -> u64 {
        self.totals[Cause::Busy as usize]
    }

    /// Cycles by cause, in a run of `cycles`, which none that was counted exceeds.
    pub fn until(&self, cycles: u64) -> [u64; Cause::ALL.len()] {
        let mut totals = self.totals;
        totals[self.idle as usize] += cycles - self.from;
        totals
    }
}
