//! Miss status holding registers (Kroft 1981): lines on their way, and who waits for them.

use crate::quantity::LineAddr;
use crate::stats::TrafficClass;

/// What becomes of a line when it comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fate {
    /// Whether an access that waits makes it dirty.
    pub dirty: bool,
    /// Whether an access that waits gives it a place.
    pub keep: bool,
}

/// A line on its way.
#[derive(Clone, Debug)]
struct Register {
    line: LineAddr,
    class: TrafficClass,
    fate: Fate,
    /// Accesses that wait, writes without an answer included.
    merged: usize,
    waiting: Vec<u32>,
}

/// The registers of a cache.
#[derive(Clone, Debug)]
pub(crate) struct MshrFile {
    registers: Vec<Register>,
    used: usize,
    targets: usize,
}

/// A register in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RegisterId(usize);

impl MshrFile {
    /// `registers` free registers, each for `targets` accesses.
    pub(crate) fn new(registers: usize, targets: usize) -> Self {
        let free = Register {
            line: LineAddr(u64::MAX),
            class: TrafficClass::Node,
            fate: Fate { dirty: false, keep: false },
            merged: 0,
            waiting: Vec::with_capacity(targets.min(64)),
        };
        Self { registers: vec![free; registers], used: 0, targets }
    }

    /// The register that holds `line`.
    #[inline]
    pub(crate) fn find(&self, line: LineAddr) -> Option<RegisterId> {
        self.registers[..self.used].iter().position(|register| register.line == line).map(RegisterId)
    }

    /// The lines on their way.
    pub(crate) fn lines(&self) -> impl Iterator<Item = LineAddr> {
        self.registers[..self.used].iter().map(|register| register.line)
    }

    /// Whether no register is free.
    pub(crate) fn is_full(&self) -> bool {
        self.used == self.registers.len()
    }

    /// Registers in use.
    pub(crate) fn len(&self) -> usize {
        self.used
    }

    /// Adds an access to a line on its way; false if the register has no target left.
    #[inline]
    pub(crate) fn merge(&mut self, id: RegisterId, fate: Fate, waiting: Option<u32>) -> bool {
        let register = &mut self.registers[id.0];
        if register.merged == self.targets {
            return false;
        }
        register.merged += 1;
        register.fate.dirty |= fate.dirty;
        register.fate.keep |= fate.keep;
        register.waiting.extend(waiting);
        true
    }

    /// Takes a free register for `line`; the caller has asked [`MshrFile::is_full`].
    #[inline]
    pub(crate) fn allocate(&mut self, line: LineAddr, class: TrafficClass, fate: Fate, waiting: Option<u32>) {
        let register = &mut self.registers[self.used];
        (register.line, register.class, register.fate, register.merged) = (line, class, fate, 1);
        register.waiting.clear();
        register.waiting.extend(waiting);
        self.used += 1;
    }

    /// What the line of a register is for, and what becomes of it.
    #[inline]
    pub(crate) fn missed(&self, id: RegisterId) -> (TrafficClass, Fate) {
        let register = &self.registers[id.0];
        (register.class, register.fate)
    }

    /// Frees the register and appends who waits to `waiting`, in the order of their accesses.
    #[inline]
    pub(crate) fn release(&mut self, id: RegisterId, waiting: &mut Vec<u32>) {
        // Few wait: one by one takes fewer instructions than a copy.
        self.registers[id.0].waiting.iter().for_each(|&who| waiting.push(who));
        self.used -= 1;
        self.registers.swap(id.0, self.used);
    }
}
