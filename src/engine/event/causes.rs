//! Why each cycle of a unit went as it did, counted at changes: a part that is not looked at does not change.

use crate::memory::ring::Ring;
use crate::stats::Cause;

/// Cycles that operations occupy, one right after another: from the first to before the second.
type Run = (u64, u64);

/// Runs that have passed may stay in the list up to this length.
const MOST_RUNS: usize = 16;

/// A unit's cycles by cause.
#[derive(Clone, Debug)]
pub(crate) struct Causes {
    /// Idle cycles before `from`, by cause.
    totals: [u64; Cause::ALL.len()],
    /// The cause of the cycles from `from` on in which the unit is not busy, until something happens.
    idle: Cause,
    from: u64,
    /// Cycles that operations occupy, those that are still to come included.
    busy: u64,
    /// How many of them lie before `from`.
    busy_before: u64,
    /// Those that may not have passed, in order, but for the last, and how many cycles these are.
    runs: Ring<Run>,
    listed: u64,
    last: Run,
    /// A cycle to come in which the last of the operations begins that are known to, [`u64::MAX`] if none is, and the
    /// cause of those after it.
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
    /// An operation begins in cycle `at`, after all others, and occupies its entry for so many cycles.
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

    /// Cycle `now` has passed: in it, and in those after it until something happens, `idle` is the cause if no
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

    /// As [`Causes::cycle`], where the cause may be another one than before.
    fn cycle_that_changes(&mut self, now: u64, idle: Cause) {
        self.drop_runs(self.ahead_at.min(now));
        if self.ahead_at <= now {
            self.change(self.ahead_at, self.ahead_idle);
            self.ahead_at = u64::MAX;
        }
        self.change(now, idle);
    }

    /// Cycle `now` has passed, in which the unit took as many rays as it can, others waited, and no operation
    /// began: it is lost at the intake if no earlier operation occupies it. Later cycles are `idle`'s as after
    /// [`Causes::cycle`].
    pub(crate) fn passed_by(&mut self, now: u64, idle: Cause) {
        self.cycle(now, Cause::Intake);
        self.change(now + 1, idle);
    }

    /// Whether operations occupy all cycles from `at` to the last that is known to be busy.
    #[inline]
    pub(crate) fn is_busy_from(&self, at: u64) -> bool {
        self.last.0 <= at && at < self.last.1
    }

    /// From cycle `at` on, which is to come and in which the last operation begins that is known to, `idle` is the
    /// cause.
    #[inline]
    pub(crate) fn ahead(&mut self, at: u64, idle: Cause) {
        (self.ahead_at, self.ahead_idle) = (at, idle);
    }

    /// From cycle `now` on, `idle` is the cause.
    #[inline]
    fn change(&mut self, now: u64, idle: Cause) {
        if idle != self.idle {
            self.settle(now);
            self.idle = idle;
        }
    }

    /// Forgets runs that end before cycle `now`.
    #[inline]
    fn drop_runs(&mut self, now: u64) {
        while let Some(&(from, until)) = self.runs.front().filter(|run| run.1 <= now) {
            self.runs.drop_front();
            self.listed -= until - from;
        }
    }

    /// Counts the idle cycles before `now`.
    fn settle(&mut self, now: u64) {
        self.drop_runs(now);
        // Of the runs in the list, only the first may have begun.
        let begun = self.runs.front().map_or(0, |run| now.saturating_sub(run.0));
        let last = self.last.1.saturating_sub(self.last.0.max(now));
        let busy_before = self.busy - (self.listed - begun + last);
        self.totals[self.idle as usize] += (now - self.from) - (busy_before - self.busy_before);
        (self.from, self.busy_before) = (now, busy_before);
    }

    /// Cycles in which an operation occupied the unit, so far as is known.
    pub(crate) fn busy(&self) -> u64 {
        self.busy
    }

    /// Cycles by cause, in a run of `cycles`; of a unit that is ahead of them, of those up to where it is. Of an
    /// operation that is known to begin in the last one, its ray still waits.
    pub(crate) fn until(&self, cycles: u64) -> [u64; Cause::ALL.len()] {
        let cycles = cycles.max(self.from);
        let mut end = self.clone();
        // Saturating: no cycle is known ahead.
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
