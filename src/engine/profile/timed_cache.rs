//! A cache in which each line on its way has an arrival cycle: an access is decided at once.

use crate::engine::tally::PerClass;
use crate::memory::allocation::NoAllocate;
use crate::memory::cache::Access;
use crate::memory::mshr::FillPolicy;
use crate::memory::tags::{TagArray, Victim};
use crate::quantity::LineAddr;
use crate::stats::{CacheCounts, TrafficClass};

/// A line on its way.
#[derive(Clone, Copy, Debug)]
struct PendingFill {
    line: LineAddr,
    at: u64,
    class: TrafficClass,
    fill: FillPolicy,
    /// Accesses that wait for the line.
    targets: usize,
}

/// The result of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lookup {
    /// The line is there.
    Hit,
    /// MSHR hit: the access gets the line in this cycle.
    MshrHit(u64),
    /// Miss: the caller says with [`TimedCache::schedule_fill`] when the line comes.
    Miss,
    /// A write that does not allocate its line: the caller sends it down.
    WriteAround,
}

/// The cache.
#[derive(Clone, Debug)]
pub(super) struct TimedCache {
    tags: TagArray,
    no_allocate: NoAllocate,
    coming: Vec<PendingFill>,
    /// The earliest arrival in `coming`.
    next_at: u64,
    registers: usize,
    targets: usize,
    /// Cycles between two accesses that get a line that has come.
    apart: u64,
    counts: PerClass<CacheCounts>,
}

impl TimedCache {
    /// An empty cache with `registers` MSHRs of `targets` targets each. The waiting accesses get a line that has come
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

    /// Accesses `line` in cycle `at`, or as soon as an MSHR or target is free. Returns the cycle and the result.
    /// `waits` says whether the access needs data, so that a line is fetched even if it is not allocated. Dirty victims
    /// up to then are passed to `gone`, with their cycle.
    #[inline]
    pub(super) fn access(
        &mut self,
        line: LineAddr,
        class: TrafficClass,
        access: Access,
        waits: bool,
        at: u64,
        gone: &mut impl FnMut(Victim, u64),
    ) -> (u64, Lookup) {
        self.arrive(at, gone);
        if self.hit(line, class, access) {
            return (at, Lookup::Hit);
        }
        self.counts[class as usize].accesses += 1;
        self.miss(line, class, access, waits, at, gone)
    }

    /// Accesses `line` if it is there; returns whether it is. The caller has called `arrive`.
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

    /// Completes an access to a line that is not there at first.
    #[inline(never)]
    fn miss(
        &mut self,
        line: LineAddr,
        class: TrafficClass,
        access: Access,
        waits: bool,
        mut at: u64,
        gone: &mut impl FnMut(Victim, u64),
    ) -> (u64, Lookup) {
        let (counts, fill) = (class as usize, access.fill(class, &self.no_allocate));
        loop {
            if let Some(coming) = self.coming.iter_mut().find(|coming| coming.line == line) {
                if coming.targets < self.targets {
                    let comes = coming.at + self.apart * coming.targets as u64;
                    coming.targets += 1;
                    coming.fill.dirty |= fill.dirty;
                    coming.fill.keep |= fill.keep;
                    self.counts[counts].mshr_hits += 1;
                    return (at, Lookup::MshrHit(comes));
                }
                at = coming.at;
            } else if !waits && !fill.keep {
                self.counts[counts].passed_writes += 1;
                return (at, Lookup::WriteAround);
            } else if self.coming.len() < self.registers {
                self.counts[counts].misses += 1;
                return (at, Lookup::Miss);
            } else {
                at = self.next_at;
            }
            self.arrive(at, gone);
            if self.tags.access(line, fill.dirty) {
                self.counts[counts].hits += 1;
                return (at, Lookup::Hit);
            }
        }
    }

    /// Until when an access to `line` must wait for an MSHR, if it must. The caller has called `arrive`.
    #[inline]
    pub(super) fn full_until(&self, line: LineAddr) -> Option<u64> {
        let free = self.coming.len() < self.registers
            || self.tags.contains(line)
            || self.coming.iter().any(|coming| coming.line == line);
        (!free).then_some(self.next_at)
    }

    /// The line just missed comes in cycle `at`.
    pub(super) fn schedule_fill(&mut self, line: LineAddr, class: TrafficClass, access: Access, at: u64) {
        let fill = access.fill(class, &self.no_allocate);
        self.coming.push(PendingFill { line, at, class, fill, targets: 1 });
        self.next_at = self.next_at.min(at);
    }

    /// Whether a line that comes up to cycle `at` is not filled yet.
    #[inline]
    pub(super) fn comes_by(&self, at: u64) -> bool {
        self.next_at <= at
    }

    /// Fills all lines that come up to cycle `at`.
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
            let PendingFill { line, at: came, class, fill, .. } = self.coming.remove(first);
            self.next_at = self.coming.iter().map(|coming| coming.at).min().unwrap_or(u64::MAX);
            let victim = if fill.keep {
                self.tags.fill(line, class, fill.dirty)
            } else {
                Some(Victim { line, class, dirty: fill.dirty })
            };
            if let Some(victim) = victim.filter(|victim| victim.dirty) {
                self.counts[victim.class as usize].write_backs += 1;
                gone(victim, came);
            }
        }
    }

    /// The cycle of the last arrival.
    pub(super) fn settled_at(&self) -> u64 {
        self.coming.iter().map(|coming| coming.at).max().unwrap_or(0)
    }

    /// Loads the contents of `tags`, except lines that are on their way.
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
