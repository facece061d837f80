//! Lines that were touched.

use fixedbitset::FixedBitSet;

use crate::machine::MachineSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::memory::l2::Home;
use crate::memory::tags::Contents;
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// Something for each class of traffic.
type PerClass<T> = [T; TrafficClass::ALL.len()];

/// The lines that units touched, and what moves at least for each line's first touch.
#[derive(Clone, Debug)]
pub struct Lines {
    /// Lines that each kind of units touched, and that any did.
    by_kind: [FixedBitSet; Kind::ALL.len()],
    by_any: FixedBitSet,
    /// Whether L1s of each kind, and the L2's cache for a class, are ideal.
    ideal_l1s: [bool; Kind::ALL.len()],
    ideal_homes: PerClass<bool>,
    homes: PerClass<Home>,
    /// Requests of the phase to banks of the L2 and to channels of the DRAM.
    pub banks: Vec<u64>,
    pub channels: Vec<u64>,
    /// Bytes of the run between the L1s and the L2, and of the DRAM, and lines that were touched first.
    pub l2: PerClass<Bytes>,
    pub dram: PerClass<Bytes>,
    pub first_touches: u64,
}

impl Lines {
    /// No line of `machine` was touched.
    pub fn new(machine: &MachineSpec, kinds: &[KindSpec; Kind::ALL.len()]) -> Self {
        let caches = machine.l2.caches();
        Self {
            by_kind: Default::default(),
            by_any: FixedBitSet::new(),
            ideal_l1s: kinds.each_ref().map(|kind| kind.cache.contents == Contents::Ideal),
            ideal_homes: TrafficClass::ALL.map(|class| caches[machine.l2.home(class)].1.contents == Contents::Ideal),
            homes: machine.l2.homes(),
            banks: vec![0; machine.l2.banks() as usize],
            channels: vec![0; machine.dram.channels.size()],
            l2: Default::default(),
            dram: Default::default(),
            first_touches: 0,
        }
    }

    /// A unit of a kind touches `count` lines from `first` on.
    pub fn touch(&mut self, machine: &MachineSpec, kind: Kind, class: TrafficClass, first: LineAddr, count: u64) {
        let size = Bytes(machine.line_bytes.get());
        let class = class as usize;
        if self.ideal_l1s[kind as usize] {
            return;
        }
        for line in first.0..first.0 + count {
            if is_first(&mut self.by_kind[kind as usize], line) {
                self.banks[self.homes[class].bank(LineAddr(line))] += 1;
                self.l2[class] += size;
                if !self.ideal_homes[class] && is_first(&mut self.by_any, line) {
                    self.channels[machine.dram.place(LineAddr(line)).channel] += 1;
                    self.dram[class] += size;
                    self.first_touches += 1;
                }
            }
        }
    }

    /// A frame begins: lines from `first` on are new.
    pub fn forget_from(&mut self, first: LineAddr) {
        self.by_kind.iter_mut().chain([&mut self.by_any]).for_each(|lines| forget_from(lines, first.0 as usize));
    }

    /// Another phase begins.
    pub fn end_phase(&mut self) {
        self.banks.fill(0);
        self.channels.fill(0);
    }
}

/// Takes members from `first` on out of a set.
pub fn forget_from(set: &mut FixedBitSet, first: usize) {
    if first < set.len() {
        set.remove_range(first..);
    }
}

/// Puts a line into a set; whether it is new.
fn is_first(lines: &mut FixedBitSet, line: u64) -> bool {
    let line = line as usize;
    if line >= lines.len() {
        // Twice as much: growing copies.
        lines.grow((line + 1).next_power_of_two());
    }
    !lines.put(line)
}
