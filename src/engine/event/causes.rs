//! Counts a unit's cycles by cause, at changes only: while a unit does not act, its cause stays the same.

use crate::memory::ring::Ring;
use crate::stats::Cause;

/// Cycles that operations occupy without a gap: the first cycle, and the cycle after the last.
type Run = (u64, u64);

/// Past runs are dropped from the list when it has this length, or when the cause changes.
const MOST_RUNS: usize = 16;

/// A unit's cycles by cause.
#[derive(Clone, Debug)]
pub(crate) struct Causes {
    /// Idle cycles before `from`, by cause.
    totals: [u64; Cause::ALL.len()],
    /// The cause of idle cycles from `from` on, until something happens.
    idle: Cause,
    from: u64,
    /// Number of busy cycles, including those still to come.
    busy: u64,
    /// Number of busy cycles before `from`.
    busy_before: u64,
    /// Runs that may not have passed, in order, without the last one; and the number of their cycles.
    runs: Ring<Run>,
    listed: u64,
    last: Run,
    /// A cycle to come, in which the last known operation begins ([`u64::MAX`] if none is known), and the cause of
    /// idle cycles after it.
    ahead_at: u64,
    ahead_idle: Cause,
}

impl Default for Causes {
    fn default() -> Self {
        let totals = [0; Cause::ALL.len()];
        Self {
            totals,
            idle: Cause::Starved,
            from: 0,
            busy: 0,
            busy_before: 0,
            runs: Ring::new(),
            listed: 0,
            last: (0, 0),
            ahead_at: u64::MAX,
            ahead_idle: Cause::Starved,
        }
    }
}

impl Causes {
    /// An operation begins in cycle `at`, after all others, and occupies its entry for `cycles` cycles.
    #[inline]
    pub(crate) fn begin(&mut self, at: u64, cycles: u64) {
        self.busy += cycles;
        if self.last.1 == at {
            self.last.1 += cycles;
        } else {
            self.runs.push_back(self.last);
            self.listed += self.last.1 - self.last.0;
            self.last = (at, at + cycles);
        }
    }

    /// Cycle `now` has passed. `idle` is the cause of this cycle, and of later ones until something happens, where no
    /// operation occupies the unit.
    #[inline]
    pub(crate) fn cycle(&mut self, now: u64, idle: Cause) {
        if idle == self.idle && self.runs.len() < MOST_RUNS {
            if self.ahead_at > now {
                return;
            }
            if self.ahead_idle == idle {
                self.ahead_at = u64::MAX;
                return;
            }
        }
        self.cycle_that_changes(now, idle);
    }

    /// [`Causes::cycle`] where the cause may change.
    fn cycle_that_changes(&mut self, now: u64, idle: Cause) {
        self.drop_runs(self.ahead_at.min(now));
        if self.ahead_at <= now {
            self.change(self.ahead_at, self.ahead_idle);
            self.ahead_at = u64::MAX;
        }
        self.change(now, idle);
    }

    /// Cycle `now` has passed, in which the unit took as many rays as it can, others waited, and no operation began.
    /// Its cause is the intake, unless an earlier operation occupies it. Later idle cycles have the cause `idle`.
    pub(crate) fn passed_by(&mut self, now: u64, idle: Cause) {
        self.cycle(now, Cause::Intake);
        self.change(now + 1, idle);
    }

    /// Whether operations occupy all cycles from `at` to the last cycle known to be busy.
    #[inline]
    pub(crate) fn is_busy_from(&self, at: u64) -> bool {
        self.last.0 <= at && at < self.last.1
    }

    /// Sets the cause of idle cycles from `at` on: a cycle to come, in which the last known operation begins.
    #[inline]
    pub(crate) fn ahead(&mut self, at: u64, idle: Cause) {
        (self.ahead_at, self.ahead_idle) = (at, idle);
    }

    /// Sets the cause of idle cycles from `now` on.
    #[inline]
    fn change(&mut self, now: u64, idle: Cause) {
        if idle != self.idle {
            self.settle(now);
            self.idle = idle;
        }
    }

    /// Drops runs that end before cycle `now`.
    #[inline]
    fn drop_runs(&mut self, now: u64) {
        while let Some(&(from, until)) = self.runs.front().filter(|run| run.1 <= now) {
            self.runs.drop_front();
            self.listed -= until - from;
        }
    }

    /// Adds the idle cycles before `now` to `totals`.
    fn settle(&mut self, now: u64) {
        self.drop_runs(now);
        // Of the listed runs, only the first may have begun.
        let begun = self.runs.front().map_or(0, |run| now.saturating_sub(run.0));
        let last = self.last.1.saturating_sub(self.last.0.max(now));
        let busy_before = self.busy - (self.listed - begun + last);
        self.totals[self.idle as usize] += (now - self.from) - (busy_before - self.busy_before);
        (self.from, self.busy_before) = (now, busy_before);
    }

    /// Number of busy cycles, including known cycles to come.
    pub(crate) fn busy(&self) -> u64 {
        self.busy
    }

    /// Cycles by cause in a run of `cycles`; for a unit that is ahead, in the cycles up to where it is. If a known
    /// operation begins in the last cycle, that cycle still counts as waiting.
    pub(crate) fn until(&self, cycles: u64) -> [u64; Cause::ALL.len()] {
        let cycles = cycles.max(self.from);
        let mut end = self.clone();
        // Saturates if no cycle is known ahead.
        let known = self.ahead_at.saturating_add(1);
        if known < cycles {
            end.change(self.ahead_at, self.ahead_idle);
        }
        end.settle(cycles);
        end.totals[Cause::Busy as usize] += end.busy_before;
        if known == cycles {
            end.totals[Cause::Busy as usize] -= 1;
            end.totals[end.idle as usize] += 1;
        }
        end.totals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cycle_has_one_cause() {
        let mut causes = Causes::default();
        let of = |causes: &Causes, cycles| Cause::ALL.map(|cause| (cause, causes.until(cycles)[cause as usize]));
        causes.cycle(2, Cause::Memory);
        causes.begin(3, 4);
        causes.cycle(3, Cause::Pipeline);
        causes.begin(9, 2);
        causes.ahead(9, Cause::Starved);
        let of_cause = |cycles, cause| of(&causes, cycles).into_iter().find(|&(it, _)| it == cause).map(|(_, it)| it);
        // Starved 0 and 1, waiting for memory in 2, busy 3 to 6, in the pipeline 7 and 8, busy 9 and 10, starved 11.
        for (cycles, busy, starved) in [(3, 0, 2), (5, 2, 2), (12, 6, 3)] {
            assert_eq!((of_cause(cycles, Cause::Busy), of_cause(cycles, Cause::Starved)), (Some(busy), Some(starved)));
            assert_eq!(causes.until(cycles).iter().sum::<u64>(), cycles);
        }
    }
}
