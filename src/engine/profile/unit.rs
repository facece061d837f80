//! A unit as a time from which it is free: an operation takes its place in the pipeline when it requests its data.

use std::collections::VecDeque;

use super::memory::Memory;
use super::timed_cache::{Lookup, TimedCache};
use super::watch::Watch;
use crate::engine::tally::{PerClass, UnitTally, busy};
use crate::machine::kinds::KindSpec;
use crate::machine::layout::{Element, Layout};
use crate::machine::writes::WritePolicy;
use crate::memory::cache::BypassCounts;
use crate::memory::cache::{Access, CacheSpec, Release};
use crate::memory::tags::TagArray;
use crate::memory::tags::Victim;
use crate::quantity::{Bytes, LineAddr};

/// The unit.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    level: TimedCache,
    line: Bytes,
    /// Port cycles per access when its line comes: 1 with `Release::OneByOne`, otherwise 0.
    released_in: u64,
    ports: u64,
    hit_latency: u64,
    latency: u64,
    interval: u64,
    /// Operations that can begin in one cycle, each with a port; the number begun in cycle `last_begun`.
    width: u64,
    begun: u64,
    last_begun: u64,
    core: usize,
    number: usize,
    writes: WritePolicy,
    free_at: u64,
    /// Rays that wait for an MSHR; the first ray is on the agenda.
    pub stalled: VecDeque<u32>,
    operations: u64,
    requested: PerClass<Bytes>,
    written_through: PerClass<BypassCounts>,
    /// Arrival cycles of reads that bypass the L1, and the maximum number of such reads under way.
    bypassing: Vec<u64>,
    most_bypassing: usize,
    bypassed: PerClass<BypassCounts>,
    attributed: PerClass<u64>,
}

impl Unit {
    /// The empty unit `number` of all units, in core `core`.
    pub(super) fn new(spec: &KindSpec, number: usize, core: usize, line: u64) -> Self {
        let CacheSpec { no_allocate, mshrs, targets, .. } = spec.cache;
        let released_in = u64::from(spec.cache.release == Release::OneByOne);
        Self {
            level: TimedCache::new(spec.cache.tags(line), no_allocate, mshrs.get(), targets.get(), released_in),
            line: Bytes(line),
            released_in,
            ports: spec.cache.accesses_per_cycle(),
            hit_latency: spec.cache.latency.get(),
            latency: spec.latency,
            interval: spec.interval,
            width: spec.width.min(spec.cache.accesses_per_cycle()),
            begun: 0,
            last_begun: 0,
            core,
            number,
            writes: spec.writes,
            free_at: 0,
            stalled: VecDeque::new(),
            operations: 0,
            requested: PerClass::default(),
            written_through: PerClass::default(),
            bypassing: Vec::new(),
            most_bypassing: mshrs.size(),
            bypassed: PerClass::default(),
            attributed: PerClass::default(),
        }
    }

    /// Performs an operation on `element`, requested in cycle `at`; `attributed` says whether its misses count among
    /// the attributed ones. Returns the cycle of its end, or as an error the cycle to try again, when an MSHR is free.
    pub(super) fn perform<W: Watch>(
        &mut self,
        element: &Element,
        attributed: bool,
        at: u64,
        layout: &Layout,
        memory: &mut Memory<W>,
    ) -> Result<u64, u64> {
        let (first, lines) = layout.lines(element);
        let (class, access) = (element.class, self.writes.access(element.class, element.write));
        let mut at = at.max(self.free_at);
        let (mut data_at, mut releases) = (at, 0);
        let (size, core) = (self.line, self.core);
        let mut gone = |victim: Victim, at| memory.write(core, victim.line, victim.class, size, at);
        self.level.arrive(at, &mut gone);
        // Fast path: most operations need one line, which is there.
        if lines == 1 && access != Access::WriteThrough && self.level.hit(first, class, access) {
            memory.watch.l1(self.number, first, class);
            self.began(at, self.interval);
            self.requested[class as usize] += Bytes(element.bytes);
            return Ok(at + self.hit_latency + self.latency);
        }
        if let Some(until) = self.level.full_until(first) {
            return Err(until);
        }
        for line in first.0..first.0 + lines {
            let line = LineAddr(line);
            memory.watch.l1(self.number, line, class);
            let mut gone = |victim: Victim, at| memory.write(core, victim.line, victim.class, size, at);
            let (when, found) = self.level.access(line, class, access, true, at, &mut gone);
            let came = match found {
                Lookup::Hit => when + self.hit_latency,
                Lookup::MshrHit(at) => at,
                Lookup::WriteAround => unreachable!("a ray waits for the data"),
                Lookup::Miss => {
                    self.attributed[class as usize] += u64::from(attributed);
                    let comes = memory.read(core, (line, size), class, attributed, when);
                    self.level.schedule_fill(line, class, access, comes);
                    comes
                }
            };
            (at, data_at) = (when, data_at.max(came));
            releases += if found == Lookup::Hit { 0 } else { self.released_in };
        }
        self.began(at, releases + lines.div_ceil(self.ports).max(self.interval));
        self.requested[class as usize] += Bytes(element.bytes);
        if access == Access::WriteThrough {
            self.written_through[class as usize].add(Bytes(element.bytes));
            memory.write(core, first, class, Bytes(element.bytes), data_at);
        }
        Ok(data_at + self.latency)
    }

    /// As [`Self::perform`] for the most common case, a read of one line that is there; `None` in all other cases.
    #[inline]
    pub(super) fn visit<W: Watch>(
        &mut self,
        element: &Element,
        at: u64,
        layout: &Layout,
        watch: &mut W,
    ) -> Option<u64> {
        let ((line, lines), at) = (layout.lines(element), at.max(self.free_at));
        let waits = lines > 1 || !self.stalled.is_empty() || self.level.comes_by(at);
        if waits || !self.level.hit(line, element.class, Access::Read) {
            return None;
        }
        watch.l1(self.number, line, element.class);
        self.began(at, self.interval);
        self.requested[element.class as usize] += Bytes(element.bytes);
        Some(at + self.hit_latency + self.latency)
    }

    /// As [`Self::perform`] with data from the L2 that bypass the L1.
    pub(super) fn perform_bypass<W: Watch>(
        &mut self,
        element: &Element,
        attributed: bool,
        at: u64,
        layout: &Layout,
        memory: &mut Memory<W>,
    ) -> Result<u64, u64> {
        let at = at.max(self.free_at);
        self.bypassing.retain(|&comes| comes > at);
        let soonest = self.bypassing.iter().min().copied();
        if let Some(until) = soonest.filter(|_| self.bypassing.len() == self.most_bypassing) {
            return Err(until);
        }
        let ((line, _), class, bytes) = (layout.lines(element), element.class, Bytes(element.bytes));
        let comes = memory.read(self.core, (line, bytes), class, attributed, at);
        self.bypassing.push(comes);
        self.bypassed[class as usize].add(bytes);
        self.began(at, self.interval);
        if element.write {
            self.written_through[class as usize].add(bytes);
            memory.write(self.core, line, class, bytes, comes);
        }
        Ok(comes + self.latency)
    }

    /// An operation that writes to the L2 and needs no data; returns the cycle of its end.
    pub(super) fn write_bypass<W: Watch>(
        &mut self,
        element: &Element,
        at: u64,
        layout: &Layout,
        memory: &mut Memory<W>,
    ) -> u64 {
        let at = at.max(self.free_at);
        self.began(at, self.interval);
        let ((line, _), class, bytes) = (layout.lines(element), element.class, Bytes(element.bytes));
        self.written_through[class as usize].add(bytes);
        memory.write(self.core, line, class, bytes, at);
        at + self.latency
    }

    /// An operation without data; returns the cycle of its end.
    pub(super) fn decide(&mut self, at: u64) -> u64 {
        let at = at.max(self.free_at);
        self.began(at, self.interval);
        at + self.latency
    }

    /// Counts an operation begun in cycle `at`. It occupies the unit for `cycles` cycles, unless more operations can
    /// begin in the same cycle.
    fn began(&mut self, at: u64, cycles: u64) {
        self.operations += 1;
        self.begun = if at == self.last_begun { self.begun + 1 } else { 1 };
        self.last_begun = at;
        let more = self.begun < self.width && cycles == self.interval;
        self.free_at = if more { at } else { at + cycles };
    }

    /// The unit's core.
    pub(super) fn core(&self) -> usize {
        self.core
    }

    /// Fills all lines that come up to cycle `at`.
    pub(super) fn settle<W: Watch>(&mut self, at: u64, memory: &mut Memory<W>) {
        let (size, core) = (self.line, self.core);
        self.level.arrive(at, &mut |victim, at| memory.write(core, victim.line, victim.class, size, at));
    }

    /// Loads the contents of `tags` into the L1.
    pub(super) fn hold(&mut self, tags: &TagArray) {
        self.level.hold(tags);
    }

    /// The cycle of the last arrival or operation.
    pub(super) fn settled_at(&self) -> u64 {
        self.level.settled_at().max(self.free_at)
    }

    /// A frame begins in cycle `at`: drops lines from `first` on.
    pub(super) fn drop_from<W: Watch>(&mut self, first: LineAddr, at: u64, memory: &mut Memory<W>) {
        self.settle(at, memory);
        self.level.drop_from(first);
    }

    /// The unit's counts; `Busy` is the only known cause.
    pub(super) fn tally(&self) -> UnitTally {
        UnitTally {
            causes: busy((self.operations * self.interval).div_ceil(self.width)),
            operations: self.operations,
            cache: *self.level.counts(),
            l1: Default::default(),
            requested: self.requested,
            written_through: self.written_through,
            bypassed: self.bypassed,
            attributed: self.attributed,
        }
    }
}
