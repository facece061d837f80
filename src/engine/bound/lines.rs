//! Touched lines.

use std::ops::Range;

use fixedbitset::FixedBitSet;

use super::sums::Sums;
use crate::engine::tally::PerClass;
use crate::machine::MachineSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::memory::l2::Home;
use crate::memory::tags::Contents;
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// The lines that units touched, and the minimum traffic of each line's first touch.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    /// Lines touched by each kind of units, and by any kind.
    by_kind: [FixedBitSet; Kind::ALL.len()],
    by_any: FixedBitSet,
    /// Whether the L1s of each kind, and the L2's cache for each class, are ideal.
    ideal_l1s: [bool; Kind::ALL.len()],
    ideal_homes: PerClass<bool>,
    homes: PerClass<Home>,
    /// Requests of the phase to L2 banks and to DRAM channels.
    pub banks: Vec<u64>,
    pub channels: Vec<u64>,
}

impl Lines {
    /// A state in which no line of `machine` is touched.
    pub(super) fn new(machine: &MachineSpec, kinds: &[KindSpec; Kind::ALL.len()]) -> Self {
        let caches = machine.l2.caches();
        Self {
            by_kind: Default::default(),
            by_any: FixedBitSet::new(),
            ideal_l1s: kinds.each_ref().map(|kind| kind.cache.contents == Contents::Ideal),
            ideal_homes: TrafficClass::ALL.map(|class| caches[machine.l2.home(class)].1.contents == Contents::Ideal),
            homes: machine.l2.homes(),
            banks: vec![0; machine.l2.banks() as usize],
            channels: vec![0; machine.dram.channels.size()],
        }
    }

    /// A unit of a kind touches an element in `lines`; adds the resulting traffic to `sums`.
    pub(super) fn touch(
        &mut self,
        machine: &MachineSpec,
        (kind, class): (Kind, TrafficClass),
        lines: Range<u64>,
        sums: &mut Sums,
    ) {
        let size = Bytes(machine.line_bytes.get());
        let class = class as usize;
        if self.ideal_l1s[kind as usize] {
            return;
        }
        for line in lines {
            if is_first(&mut self.by_kind[kind as usize], line) {
                self.banks[self.homes[class].bank(LineAddr(line))] += 1;
                sums.l2[class] += size;
                if !self.ideal_homes[class] && is_first(&mut self.by_any, line) {
                    self.channels[machine.dram.place(LineAddr(line)).channel] += 1;
                    sums.dram[class] += size;
                    sums.first_touches += 1;
                }
            }
        }
    }

    /// A frame begins: lines from `first` on are untouched again.
    pub(super) fn forget_from(&mut self, first: LineAddr) {
        self.by_kind.iter_mut().chain([&mut self.by_any]).for_each(|lines| forget_from(lines, first.0 as usize));
    }

    /// Another phase begins.
    pub(super) fn end_phase(&mut self) {
        self.banks.fill(0);
        self.channels.fill(0);
    }
}

/// Removes members from `first` on from a set.
pub(super) fn forget_from(set: &mut FixedBitSet, first: usize) {
    if first < set.len() {
        set.remove_range(first..);
    }
}

/// Adds a line to a set; returns whether it is new.
fn is_first(lines: &mut FixedBitSet, line: u64) -> bool {
    let line = line as usize;
    if line >= lines.len() {
        // Doubles the size: growing copies the set.
        lines.grow((line + 1).next_power_of_two());
    }
    !lines.put(line)
}
