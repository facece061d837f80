//! A cache whose lines on their way are known by when they come: everything is decided at the moment of an access.

use crate::engine::tally::PerClass;
use crate::memory::allocation::NoAllocate;
use crate::memory::cache::Access;
use crate::memory::mshr::Fate;
use crate::memory::tags::{TagArray, Victim};
use crate::quantity::LineAddr;
use crate::stats::{CacheCounts, TrafficClass};

/// A line on its way.
#[derive(Clone, Copy, Debug)]
struct Coming {
    line: LineAddr,
    at: u64,
    class: TrafficClass,
    fate: Fate,
    /// Accesses that wait for it.
    targets: usize,
}

/// What an access met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// The line.
    Hit,
    /// A register that holds it; the access gets it then.
    Coming(u64),
    /// Nothing: the caller says with [`Level::expect`] when the line comes.
    Missing,
    /// Nothing, and the line gets no place: the caller sends the write down.
    Passed,
}

/// The cache.
#[derive(Clone, Debug)]
pub(super) struct Level {
    tags: TagArray,
    no_allocate: NoAllocate,
    coming: Vec<Coming>,
    /// When the first of them does.
    next_at: u64,
    registers: usize,
    targets: usize,
    /// Cycles between two accesses that get a line that has come.
    apart: u64,
    counts: PerClass<CacheCounts>,
}

impl Level {
    /// An empty cache with `registers` miss registers for `targets` accesses each, which get a line that has come
    /// `apart` cycles after each other.
    pub(super) fn new(tags: TagArray, no_allocate: NoAllocate, registers: u64, targets: u64, apart: u64) -> Self {
        Self {
            tags,
            no_allocate,
            coming: Vec::new(),
            next_at: u64::MAX,
            registers: registers as usize,
            targets: targets as usize,
            apart,
            counts: PerClass::default(),
        }
    }

    /// Accesses `line` in cycle `at`, or as soon as a register or target is free; gives when, and what was met. Whether
    /// the access `waits` for data says whether a line that gets no place must come all the same. Dirty lines that had
    /// to go by then are passed to `gone`, with the cycle.
    #[inline]
    pub(super) fn access(
        &mut self,
        line: LineAddr,
        class: TrafficClass,
        access: Access,
        waits: bool,
        at: u64,
        gone: &mut impl FnMut(Victim, u64),
    ) -> (u64, Found) {
        self.arrive(at, gone);
        if self.hit(line, class, access) {
            return (at, Found::Hit);
        }
        self.counts[class as usize].accesses += 1;
        self.miss(line, class, access, waits, at, gone)
    }

    /// Accesses `line` if it is there, and says whether it is. What comes has come.
    #[inline]
    pub(super) fn hit(&mut self, line: LineAddr, class: TrafficClass, access: Access) -> bool {
        let hit = self.tags.access(line, access == Access::Write);
        if hit {
            let counts = &mut self.counts[class as usize];
            counts.accesses += 1;
            counts.hits += 1;
        }
        hit
    }

    /// The access when the line is not there at first.
    #[inline(never)]
    fn miss(
        &mut self,
        line: LineAddr,
        class: TrafficClass,
        access: Access,
        waits: bool,
        mut at: u64,
        gone: &mut impl FnMut(Victim, u64),
    ) -> (u64, Found) {
        let (counts, fate) = (class as usize, self.fate(class, access));
        loop {
            if let Some(coming) = self.coming.iter_mut().find(|coming| coming.line == line) {
                if coming.targets < self.targets {
                    let comes = coming.at + self.apart * coming.targets as u64;
                    coming.targets += 1;
                    coming.fate.dirty |= fate.dirty;
                    coming.fate.keep |= fate.keep;
                    self.counts[counts].half_misses += 1;
                    return (at, Found::Coming(comes));
                }
                at = coming.at;
            } else if !waits && !fate.keep {
                self.counts[counts].passed_writes += 1;
                return (at, Found::Passed);
            } else if self.coming.len() < self.registers {
                self.counts[counts].misses += 1;
                return (at, Found::Missing);
            } else {
                at = self.next_at;
            }
            self.arrive(at, gone);
            if self.tags.access(line, fate.dirty) {
                self.counts[counts].hits += 1;
                return (at, Found::Hit);
            }
        }
    }

    /// Until when an access to `line` must wait for a register, if it must. What comes has come.
    #[inline]
    pub(super) fn full_until(&self, line: LineAddr) -> Option<u64> {
        let free = self.coming.len() < self.registers
            || self.tags.contains(line)
            || self.coming.iter().any(|coming| coming.line == line);
        (!free).then_some(self.next_at)
    }

    /// The line that was just missed comes in cycle `at`.
    pub(super) fn expect(&mut self, line: LineAddr, class: TrafficClass, access: Access, at: u64) {
        let fate = self.fate(class, access);
        self.coming.push(Coming { line, at, class, fate, targets: 1 });
        self.next_at = self.next_at.min(at);
    }

    fn fate(&self, class: TrafficClass, access: Access) -> Fate {
        Fate { dirty: access == Access::Write, keep: self.no_allocate.keeps(class, access != Access::Read) }
    }

    /// Whether a line comes up to cycle `at`, which is not put in yet.
    #[inline]
    pub(super) fn comes_by(&self, at: u64) -> bool {
        self.next_at <= at
    }

    /// All lines that come up to cycle `at` are put in.
    #[inline]
    pub(super) fn arrive(&mut self, at: u64, gone: &mut impl FnMut(Victim, u64)) {
        if self.comes_by(at) {
            self.put_in(at, gone);
        }
    }

    #[inline(never)]
    fn put_in(&mut self, at: u64, gone: &mut impl FnMut(Victim, u64)) {
        while self.next_at <= at && self.next_at < u64::MAX {
            let first = self.coming.iter().position(|coming| coming.at == self.next_at).expect("one comes first");
            let Coming { line, at: came, class, fate, .. } = self.coming.remove(first);
            self.next_at = self.coming.iter().map(|coming| coming.at).min().unwrap_or(u64::MAX);
            let victim = if fate.keep {
                self.tags.fill(line, class, fate.dirty)
            } else {
                Some(Victim { line, class, dirty: fate.dirty })
            };
            if let Some(victim) = victim.filter(|victim| victim.dirty) {
                self.counts[victim.class as usize].write_backs += 1;
                gone(victim, came);
            }
        }
    }

    /// When the last line comes.
    pub(super) fn settled_at(&self) -> u64 {
        self.coming.iter().map(|coming| coming.at).max().unwrap_or(0)
    }

    /// Holds from now on what `tags` do, but for lines that are on their way.
    pub(super) fn hold(&mut self, tags: &TagArray) {
        self.tags.clone_from(tags);
        self.coming.iter().for_each(|coming| self.tags.drop_line(coming.line));
    }

    /// Drops all lines from `first` on.
    pub(super) fn drop_from(&mut self, first: LineAddr) {
        self.tags.drop_from(first);
    }

    /// Accesses so far.
    pub(super) fn counts(&self) -> &PerClass<CacheCounts> {
        &self.counts
    }
}
