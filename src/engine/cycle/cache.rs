//! A non-blocking cache as the rules say: tags, miss registers with their targets, counts.

use crate::memory::tags::{TagArray, Victim};
use crate::quantity::LineAddr;
use crate::stats::{CacheCounts, TrafficClass};

/// A line on its way. `W` says who waits.
#[derive(Clone, Debug)]
struct Register<W> {
    line: LineAddr,
    class: TrafficClass,
    written: bool,
    targets: Vec<W>,
}

/// What an access met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    Hit,
    HalfMiss,
    Miss,
    /// Something is missing that the access needs: nothing was done.
    Stop,
}

/// A line that was filled.
#[derive(Clone, Debug)]
pub struct Filled<W> {
    /// The dirty line that it displaced.
    pub dirty_victim: Option<Victim>,
    /// Who waited, in the order of their accesses.
    pub waited: Vec<W>,
}

/// The cache.
#[derive(Clone, Debug)]
pub struct Cache<W> {
    tags: TagArray,
    registers: Vec<Register<W>>,
    most_registers: usize,
    most_targets: usize,
    pub counts: [CacheCounts; TrafficClass::ALL.len()],
}

impl<W> Cache<W> {
    pub fn new(tags: TagArray, most_registers: usize, most_targets: usize) -> Self {
        Self { tags, registers: Vec::new(), most_registers, most_targets, counts: Default::default() }
    }

    /// Accesses `line` for `who`; `write` makes it dirty. `room` says whether a request can be sent down.
    pub fn access(&mut self, line: LineAddr, class: TrafficClass, write: bool, room: bool, who: W) -> Met {
        let counts = &mut self.counts[class as usize];
        let met = if self.tags.access(line, write) {
            counts.hits += 1;
            Met::Hit
        } else if let Some(register) = self.registers.iter_mut().find(|register| register.line == line) {
            if register.targets.len() == self.most_targets {
                return Met::Stop;
            }
            register.targets.push(who);
            register.written |= write;
            counts.half_misses += 1;
            Met::HalfMiss
        } else {
            if self.registers.len() == self.most_registers || !room {
                return Met::Stop;
            }
            self.registers.push(Register { line, class, written: write, targets: vec![who] });
            counts.misses += 1;
            Met::Miss
        };
        counts.accesses += 1;
        met
    }

    /// Puts in a line that was missed; `None`, and nothing done, if a dirty line would have to go and there is no `room`.
    pub fn fill(&mut self, line: LineAddr, room: bool) -> Option<Filled<W>> {
        let dirty_victim = self.tags.victim(line).filter(|victim| victim.dirty);
        if dirty_victim.is_some() && !room {
            return None;
        }
        let index = self.registers.iter().position(|register| register.line == line);
        let register = self.registers.remove(index.expect("only a line that was missed comes"));
        self.tags.fill(line, register.class, register.written);
        if let Some(victim) = dirty_victim {
            self.counts[victim.class as usize].write_backs += 1;
        }
        Some(Filled { dirty_victim, waited: register.targets })
    }

    /// A frame begins: lines from `first` on go.
    pub fn drop_from(&mut self, first: LineAddr) {
        self.tags.drop_from(first);
    }

    /// Lines on their way.
    pub fn on_their_way(&self) -> usize {
        self.registers.len()
    }
}
