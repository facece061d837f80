//! Why each cycle of a unit went as it did, kept by intervals: a part that is not looked at does not change.

use crate::stats::Cause;

/// A unit's cycles by cause.
#[derive(Clone, Copy, Debug)]
pub struct Causes {
    totals: [u64; Cause::ALL.len()],
    /// The cause of the cycles from `from` on in which the unit is not busy, until something happens.
    idle: Cause,
    from: u64,
    /// The first cycle that no operation occupies.
    busy_until: u64,
}

impl Default for Causes {
    fn default() -> Self {
        Self { totals: [0; Cause::ALL.len()], idle: Cause::Starved, from: 0, busy_until: 0 }
    }
}

impl Causes {
    /// Cycle `now` has passed: the unit began an operation that occupies its entry for so many cycles (0: it began none), and
    /// in others `idle` is the cause until something happens.
    pub fn cycle(&mut self, now: u64, occupied: u64, idle: Cause) {
        self.totals = self.until(now);
        if occupied > 0 {
            self.busy_until = now + occupied;
        }
        self.totals[if now < self.busy_until { Cause::Busy } else { idle } as usize] += 1;
        (self.idle, self.from) = (idle, now + 1);
    }

    /// Cycles in which an operation occupied the unit, so far as they were looked at.
    pub fn busy(&self) -> u64 {
        self.totals[Cause::Busy as usize]
    }

    /// Cycles by cause, in a run of `cycles`, which none that was counted exceeds.
    pub fn until(&self, cycles: u64) -> [u64; Cause::ALL.len()] {
        let mut totals = self.totals;
        let busy = self.busy_until.clamp(self.from, cycles.max(self.from)) - self.from;
        totals[Cause::Busy as usize] += busy;
        totals[self.idle as usize] += cycles - self.from - busy;
        totals
    }
}
