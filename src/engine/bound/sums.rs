//! Sums that the bounds are computed from, per frame.

use std::ops::AddAssign;

use crate::engine::tally::PerClass;
use crate::machine::kinds::Kind;
use crate::quantity::Bytes;

/// Sums over frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    /// Minimum cycles of the frame.
    pub cycles: u64,
    /// Cycles of its rays if they run one after another.
    pub serial: u64,
    /// Traced rays.
    pub traced: u64,
    /// Answered rays, traced or not.
    pub answered: u64,
    /// Lines that the host reads and writes; lines that it reads.
    pub host_lines: u64,
    pub host_reads: u64,
    /// Lines touched for the first time.
    pub first_touches: u64,
    /// Write accesses to lines.
    pub writes: u64,
    /// Store steps that the lower bound omits.
    pub left_out: u64,
    /// Operations of each kind of units.
    pub operations: [u64; Kind::ALL.len()],
    /// Accesses of each kind of units to lines.
    pub accesses: [u64; Kind::ALL.len()],
    /// Bytes that each kind of units requests from its L1s.
    pub requested: [PerClass<Bytes>; Kind::ALL.len()],
    /// Minimum bytes between the L1s and the L2.
    pub l2: PerClass<Bytes>,
    /// Minimum bytes of the DRAM.
    pub dram: PerClass<Bytes>,
}

impl AddAssign<&Sums> for Sums {
    fn add_assign(&mut self, other: &Self) {
        self.cycles += other.cycles;
        self.serial += other.serial;
        self.traced += other.traced;
        self.answered += other.answered;
        self.first_touches += other.first_touches;
        self.host_lines += other.host_lines;
        self.host_reads += other.host_reads;
        self.writes += other.writes;
        self.left_out += other.left_out;
        add_each(&mut self.operations, &other.operations);
        add_each(&mut self.accesses, &other.accesses);
        self.requested.iter_mut().zip(&other.requested).for_each(|(sum, other)| add_each(sum, other));
        add_each(&mut self.l2, &other.l2);
        add_each(&mut self.dram, &other.dram);
    }
}

fn add_each<T: AddAssign + Copy>(sums: &mut [T], others: &[T]) {
    sums.iter_mut().zip(others).for_each(|(sum, &other)| *sum += other);
}
