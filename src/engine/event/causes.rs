//! Why each cycle of a unit went as it did, counted at changes: a part that is not looked at does not change.

use crate::stats::Cause;

/// An operation that begins in a cycle to come, as is known for sure.
#[derive(Clone, Copy, Debug)]
struct Ahead {
    at: u64,
    occupied: u64,
    idle: Cause,
}

/// A unit's cycles by cause.
#[derive(Clone, Copy, Debug)]
pub struct Causes {
    /// Idle cycles before `from`, by cause.
    totals: [u64; Cause::ALL.len()],
    /// The cause of the cycles from `from` on in which the unit is not busy, until something happens.
    idle: Cause,
    from: u64,
    /// Cycles that operations occupy, those of the last one that are still to come included.
    busy: u64,
    /// How many of them lie before `from`.
    busy_before: u64,
    /// The first cycle that no operation occupies.
    busy_until: u64,
    ahead: Option<Ahead>,
}

impl Default for Causes {
    fn default() -> Self {
        let totals = [0; Cause::ALL.len()];
        Self { totals, idle: Cause::Starved, from: 0, busy: 0, busy_before: 0, busy_until: 0, ahead: None }
    }
}

impl Causes {
    /// Cycle `now` has passed: the unit began an operation that occupies its entry for so many cycles (0: it began none), and
    /// in others `idle` is the cause until something happens.
    #[inline]
    pub fn cycle(&mut self, now: u64, occupied: u64, idle: Cause) {
        if let Some(ahead) = self.ahead.take_if(|ahead| ahead.at <= now) {
            self.note(ahead.at, ahead.occupied, ahead.idle);
        }
        self.note(now, occupied, idle);
    }

    /// Cycle `now` has passed, in which the unit took as many rays as it can, others waited, and no operation
    /// began: it is lost at the intake if no earlier operation occupies it. Later cycles are `idle`'s as after
    /// [`Causes::cycle`].
    pub fn passed_by(&mut self, now: u64, idle: Cause) {
        self.cycle(now, 0, Cause::Intake);
        self.note(now + 1, 0, idle);
    }

    /// What [`Causes::cycle`] is to be told of cycle `at`, which is to come. Nothing else happens before it.
    #[inline]
    pub fn ahead(&mut self, at: u64, occupied: u64, idle: Cause) {
        self.ahead = Some(Ahead { at, occupied, idle });
    }

    #[inline]
    fn note(&mut self, now: u64, occupied: u64, idle: Cause) {
        if idle != self.idle {
            self.settle(now);
            self.idle = idle;
        }
        if occupied > 0 {
            self.busy += occupied;
            self.busy_until = now + occupied;
        }
    }

    /// Counts the idle cycles before `now`.
    fn settle(&mut self, now: u64) {
        let busy_before = self.busy_up_to(now);
        self.totals[self.idle as usize] += (now - self.from) - (busy_before - self.busy_before);
        (self.from, self.busy_before) = (now, busy_before);
    }

    fn busy_up_to(&self, now: u64) -> u64 {
        self.busy - self.busy_until.saturating_sub(now)
    }

    /// Cycles in which an operation occupied the unit, so far as is known.
    pub fn busy(&self) -> u64 {
        self.busy
    }

    /// Cycles by cause, in a run of `cycles`, which none that was counted exceeds. Of the last cycle that counts which has passed.
    pub fn until(&self, cycles: u64) -> [u64; Cause::ALL.len()] {
        let mut end = *self;
        if let Some(Ahead { at, occupied, idle }) = self.ahead.filter(|ahead| ahead.at + 1 < cycles) {
            end.note(at, occupied, idle);
        }
        end.settle(cycles);
        end.totals[Cause::Busy as usize] += end.busy_before;
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
        causes.cycle(2, 0, Cause::Memory);
        causes.cycle(3, 4, Cause::Pipeline);
        causes.ahead(9, 2, Cause::Starved);
        let of_cause = |cycles, cause| of(&causes, cycles).into_iter().find(|&(it, _)| it == cause).map(|(_, it)| it);
        // Starved 0 and 1, waiting for memory in 2, busy 3 to 6, in the pipeline 7 and 8, busy 9 and 10, starved 11.
        for (cycles, busy, starved) in [(3, 0, 2), (5, 2, 2), (12, 6, 3)] {
            assert_eq!((of_cause(cycles, Cause::Busy), of_cause(cycles, Cause::Starved)), (Some(busy), Some(starved)));
            assert_eq!(causes.until(cycles).iter().sum::<u64>(), cycles);
        }
    }
}
