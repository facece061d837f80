//! A unit as a time from which on it is free: an operation takes its place in the pipeline when it asks for its data.

use std::collections::VecDeque;

use super::level::{Found, Level};
use super::memory::Memory;
use super::watch::Watch;
use crate::engine::tally::{PerClass, UnitTally, busy};
use crate::machine::kinds::KindSpec;
use crate::machine::layout::{Element, Layout};
use crate::machine::writes::WritePolicy;
use crate::memory::cache::Past;
use crate::memory::cache::{Access, CacheSpec, Release};
use crate::memory::tags::TagArray;
use crate::memory::tags::Victim;
use crate::quantity::{Bytes, LineAddr};

/// The unit.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    level: Level,
    line: Bytes,
    /// Cycles that each access takes from the ports when its line has come.
    released_in: u64,
    ports: u64,
    hit_latency: u64,
    latency: u64,
    interval: u64,
    /// Operations that can begin at once, each with a port, and how many did in the last cycle with one.
    width: u64,
    begun: u64,
    last_begun: u64,
    core: usize,
    number: usize,
    writes: WritePolicy,
    free_at: u64,
    /// Rays that wait for a miss register, that one first which is on the agenda.
    pub stalled: VecDeque<u32>,
    operations: u64,
    requested: PerClass<Bytes>,
    written_through: PerClass<Past>,
    /// When the lines of reads past the L1 come, and how many can be under way.
    past: Vec<u64>,
    most_past: usize,
    read_past: PerClass<Past>,
    marked: PerClass<u64>,
}

impl Unit {
    /// Unit `number` of all, of a kind in core `core`, empty.
    pub(super) fn new(spec: &KindSpec, number: usize, core: usize, line: u64) -> Self {
        let CacheSpec { no_allocate, mshrs, targets, .. } = spec.cache;
        let released_in = u64::from(spec.cache.release == Release::OneByOne);
        Self {
            level: Level::new(spec.cache.tags(line), no_allocate, mshrs.get(), targets.get(), released_in),
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
            past: Vec::new(),
            most_past: mshrs.size(),
            read_past: PerClass::default(),
            marked: PerClass::default(),
        }
    }

    /// An operation on `element` for a ray, marked or not, asked for in cycle `at`; gives when it ends, or when it is
    /// to be asked for again, since a miss register is free only then.
    pub(super) fn perform<W: Watch>(
        &mut self,
        element: &Element,
        marked: bool,
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
        // Most are of one line, which is there.
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
                Found::Hit => when + self.hit_latency,
                Found::Coming(at) => at,
                Found::Passed => unreachable!("a ray waits for the data"),
                Found::Missing => {
                    self.marked[class as usize] += u64::from(marked);
                    let comes = memory.read(core, (line, size), class, marked, when);
                    self.level.expect(line, class, access, comes);
                    comes
                }
            };
            (at, data_at) = (when, data_at.max(came));
            releases += if found == Found::Hit { 0 } else { self.released_in };
        }
        self.began(at, releases + lines.div_ceil(self.ports).max(self.interval));
        self.requested[class as usize] += Bytes(element.bytes);
        if access == Access::WriteThrough {
            self.written_through[class as usize].add(Bytes(element.bytes));
            memory.write(core, first, class, Bytes(element.bytes), data_at);
        }
        Ok(data_at + self.latency)
    }

    /// As [`Self::perform`] of a ray that reads one line, which is there, as most do; `None` where that is not so.
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

    /// As [`Self::perform`] with data from the L2, past the L1, that are not kept.
    pub(super) fn perform_past<W: Watch>(
        &mut self,
        element: &Element,
        marked: bool,
        at: u64,
        layout: &Layout,
        memory: &mut Memory<W>,
    ) -> Result<u64, u64> {
        let at = at.max(self.free_at);
        self.past.retain(|&comes| comes > at);
        let soonest = self.past.iter().min().copied();
        if let Some(until) = soonest.filter(|_| self.past.len() == self.most_past) {
            return Err(until);
        }
        let ((line, _), class, bytes) = (layout.lines(element), element.class, Bytes(element.bytes));
        let comes = memory.read(self.core, (line, bytes), class, marked, at);
        self.past.push(comes);
        self.read_past[class as usize].add(bytes);
        self.began(at, self.interval);
        if element.write {
            self.written_through[class as usize].add(bytes);
            memory.write(self.core, line, class, bytes, comes);
        }
        Ok(comes + self.latency)
    }

    /// An operation that sends what it writes to the L2 and needs no data; gives when it ends.
    pub(super) fn write_past<W: Watch>(
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

    /// An operation without data; gives when it ends.
    pub(super) fn decide(&mut self, at: u64) -> u64 {
        let at = at.max(self.free_at);
        self.began(at, self.interval);
        at + self.latency
    }

    /// An operation began in cycle `at` that takes the unit for so many cycles, if it is the last that can begin
    /// beside others.
    fn began(&mut self, at: u64, cycles: u64) {
        self.operations += 1;
        self.begun = if at == self.last_begun { self.begun + 1 } else { 1 };
        self.last_begun = at;
        let more = self.begun < self.width && cycles == self.interval;
        self.free_at = if more { at } else { at + cycles };
    }

    /// The core that the unit is of.
    pub(super) fn core(&self) -> usize {
        self.core
    }

    /// What comes up to cycle `at` has come.
    pub(super) fn settle<W: Watch>(&mut self, at: u64, memory: &mut Memory<W>) {
        let (size, core) = (self.line, self.core);
        self.level.arrive(at, &mut |victim, at| memory.write(core, victim.line, victim.class, size, at));
    }

    /// The L1 holds from now on what `tags` do.
    pub(super) fn hold(&mut self, tags: &TagArray) {
        self.level.hold(tags);
    }

    /// When the last line under way comes.
    pub(super) fn settled_at(&self) -> u64 {
        self.level.settled_at().max(self.free_at)
    }

    /// A frame begins in cycle `at`: lines from `first` on go.
    pub(super) fn drop_from<W: Watch>(&mut self, first: LineAddr, at: u64, memory: &mut Memory<W>) {
        self.settle(at, memory);
        self.level.drop_from(first);
    }

    /// What was counted: no cause but `Busy` is known.
    pub(super) fn tally(&self) -> UnitTally {
        UnitTally {
            causes: busy((self.operations * self.interval).div_ceil(self.width)),
            operations: self.operations,
            cache: *self.level.counts(),
            l1: Default::default(),
            requested: self.requested,
            written_through: self.written_through,
            read_straight: self.read_past,
            marked: self.marked,
        }
    }
}
