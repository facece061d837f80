//! A division unit.

use crate::machine::division::DivisionSpec;

/// A division unit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Division {
    /// The first cycle in which the next operation can begin.
    open_at: u64,
    /// Number of operations begun.
    pub begun: u64,
}

impl Division {
    /// Divides for a ray that comes in cycle `at`; returns the cycle of the end.
    pub(super) fn divide(&mut self, spec: &DivisionSpec, at: u64) -> u64 {
        let begin = at.max(self.open_at);
        (self.open_at, self.begun) = (begin + spec.interval.get(), self.begun + 1);
        begin + spec.latency.get()
    }
}
