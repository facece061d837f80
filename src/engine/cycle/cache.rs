//! A non-blocking cache as in the rules: tags, MSHRs with their targets, counts.

use crate::memory::allocation::NoAllocate;
use crate::memory::tags::{TagArray, Victim};
use crate::quantity::LineAddr;
use crate::stats::{CacheCounts, TrafficClass};

/// A line on its way. `W` identifies a waiting access.
#[derive(Clone, Debug)]
struct Register<W> {
    line: LineAddr,
    class: TrafficClass,
    written: bool,
    kept: bool,
    targets: Vec<W>,
}

/// An access to a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineAccess {
    pub line: LineAddr,
    pub class: TrafficClass,
    pub write: bool,
    /// Whether the line becomes dirty.
    pub dirties: bool,
    pub needs_data: bool,
}

/// The result of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lookup {
    Hit,
    MshrHit,
    Miss,
    /// A write that does not allocate its line: the caller sends it down.
    WriteAround,
    /// The access lacks an MSHR, a target or a place in the output queue: nothing was done.
    Stop,
}

/// A line that was filled.
#[derive(Clone, Debug)]
pub(super) struct Fill<W> {
    /// The dirty line that it displaced.
    pub dirty_victim: Option<Victim>,
    /// The waiting accesses, oldest first.
    pub waited: Vec<W>,
}

/// The cache.
#[derive(Clone, Debug)]
pub(super) struct Cache<W> {
    tags: TagArray,
    no_allocate: NoAllocate,
    registers: Vec<Register<W>>,
    most_registers: usize,
    most_targets: usize,
    pub counts: [CacheCounts; TrafficClass::ALL.len()],
}

impl<W> Cache<W> {
    pub(super) fn new(tags: TagArray, no_allocate: NoAllocate, most_registers: usize, most_targets: usize) -> Self {
        Self { tags, no_allocate, registers: Vec::new(), most_registers, most_targets, counts: Default::default() }
    }

    /// An access for `who`. `room` says whether the output queue has a place.
    pub(super) fn access(&mut self, asked: LineAccess, room: bool, who: W) -> Lookup {
        let LineAccess { line, class, write, dirties, needs_data } = asked;
        let unallocated = if write { self.no_allocate.writes } else { self.no_allocate.reads };
        let allocates = !unallocated.contains(class);
        let counts = &mut self.counts[class as usize];
        let met = if self.tags.access(line, dirties) {
            counts.hits += 1;
            Lookup::Hit
        } else if let Some(register) = self.registers.iter_mut().find(|register| register.line == line) {
            if register.targets.len() == self.most_targets {
                return Lookup::Stop;
            }
            register.targets.push(who);
            register.written |= dirties;
            register.kept |= allocates;
            counts.mshr_hits += 1;
            Lookup::MshrHit
        } else if !allocates && !needs_data {
            if !room {
                return Lookup::Stop;
            }
            counts.passed_writes += 1;
            Lookup::WriteAround
        } else {
            if self.registers.len() == self.most_registers || !room {
                return Lookup::Stop;
            }
            self.registers.push(Register { line, class, written: dirties, kept: allocates, targets: vec![who] });
            counts.misses += 1;
            Lookup::Miss
        };
        counts.accesses += 1;
        met
    }

    /// Fills a missed line. Returns `None` and does nothing if the victim is dirty and there is no `room`. A line that
    /// is not allocated is not filled; if it was written, it goes down itself.
    pub(super) fn fill(&mut self, line: LineAddr, room: bool) -> Option<Fill<W>> {
        let index = self.registers.iter().position(|register| register.line == line);
        let index = index.expect("only a line that was missed comes");
        let &Register { class, written, kept, .. } = &self.registers[index];
        let goes = if kept { self.tags.victim(line) } else { Some(Victim { line, class, dirty: written }) };
        let dirty_victim = goes.filter(|victim| victim.dirty);
        if dirty_victim.is_some() && !room {
            return None;
        }
        if kept {
            self.tags.fill(line, class, written);
        }
        if let Some(victim) = dirty_victim {
            self.counts[victim.class as usize].write_backs += 1;
        }
        Some(Fill { dirty_victim, waited: self.registers.remove(index).targets })
    }

    /// A frame begins: drops lines from `first` on.
    pub(super) fn drop_from(&mut self, first: LineAddr) {
        self.tags.drop_from(first);
    }

    /// Lines on their way.
    pub(super) fn on_their_way(&self) -> usize {
        self.registers.len()
    }
}
