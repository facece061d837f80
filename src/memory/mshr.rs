//! Miss status holding registers (Kroft 1981): lines on their way, and the accesses that wait for them.

use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// Fill policy of a line on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FillPolicy {
    /// Whether a waiting access makes the line dirty.
    pub dirty: bool,
    /// Whether a waiting access allocates the line.
    pub keep: bool,
}

/// A line on its way.
#[derive(Clone, Debug)]
struct Register {
    line: LineAddr,
    class: TrafficClass,
    fill: FillPolicy,
    /// Waiting accesses, including writes without an answer.
    merged: usize,
    waiting: Vec<u32>,
}

/// The MSHRs of a cache.
#[derive(Clone, Debug)]
pub(crate) struct MshrFile {
    registers: Vec<Register>,
    used: usize,
    targets: usize,
}

/// An MSHR in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RegisterId(usize);

impl MshrFile {
    /// Creates `registers` free MSHRs with `targets` targets each.
    pub(crate) fn new(registers: usize, targets: usize) -> Self {
        let free = Register {
            line: LineAddr(u64::MAX),
            class: TrafficClass::Node,
            fill: FillPolicy { dirty: false, keep: false },
            merged: 0,
            waiting: Vec::with_capacity(targets.min(64)),
        };
        Self { registers: vec![free; registers], used: 0, targets }
    }

    /// The MSHR of `line`.
    #[inline]
    pub(crate) fn find(&self, line: LineAddr) -> Option<RegisterId> {
        self.registers[..self.used].iter().position(|register| register.line == line).map(RegisterId)
    }

    /// The lines on their way.
    pub(crate) fn lines(&self) -> impl Iterator<Item = LineAddr> {
        self.registers[..self.used].iter().map(|register| register.line)
    }

    /// Whether no MSHR is free.
    pub(crate) fn is_full(&self) -> bool {
        self.used == self.registers.len()
    }

    /// MSHRs in use.
    pub(crate) fn len(&self) -> usize {
        self.used
    }

    /// Adds an access to a line on its way; returns false if the MSHR has no target left.
    #[inline]
    pub(crate) fn merge(&mut self, id: RegisterId, fill: FillPolicy, waiting: Option<u32>) -> bool {
        let register = &mut self.registers[id.0];
        if register.merged == self.targets {
            return false;
        }
        register.merged += 1;
        register.fill.dirty |= fill.dirty;
        register.fill.keep |= fill.keep;
        register.waiting.extend(waiting);
        true
    }

    /// Takes a free MSHR for `line`. The caller has checked [`MshrFile::is_full`].
    #[inline]
    pub(crate) fn allocate(&mut self, line: LineAddr, class: TrafficClass, fill: FillPolicy, waiting: Option<u32>) {
        let register = &mut self.registers[self.used];
        (register.line, register.class, register.fill, register.merged) = (line, class, fill, 1);
        register.waiting.clear();
        register.waiting.extend(waiting);
        self.used += 1;
    }

    /// Class and fill policy of the line in an MSHR.
    #[inline]
    pub(crate) fn missed(&self, id: RegisterId) -> (TrafficClass, FillPolicy) {
        let register = &self.registers[id.0];
        (register.class, register.fill)
    }

    /// Frees an MSHR and appends its waiting accesses to `waiting`, oldest first.
    #[inline]
    pub(crate) fn release(&mut self, id: RegisterId, waiting: &mut Vec<u32>) {
        // Waiting accesses are few: pushing one by one takes fewer instructions than a copy.
        self.registers[id.0].waiting.iter().for_each(|&who| waiting.push(who));
        self.used -= 1;
        self.registers.swap(id.0, self.used);
    }
}
