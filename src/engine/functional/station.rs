//! A unit without its cycles: an L1 with real tags and miss registers, a port and a pipeline that are each a time from which on
//! they are free.

use std::collections::VecDeque;

use crate::engine::tally::{PerClass, UnitTally, busy};
use crate::machine::kinds::KindSpec;
use crate::machine::writes::WritePolicy;
use crate::memory::cache::Past;
use crate::memory::cache::{BanksInUse, Cache, Fill, Lookup, Release};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// A fetch under way: like the machine's, but it can be asked when its data are there.
#[derive(Clone, Copy, Debug)]
pub struct Fetch {
    /// The next line to access.
    pub line: LineAddr,
    /// Lines to access from there on.
    pub left: u32,
    /// Lines accessed that have not come yet.
    pub missing: u32,
    /// Whether it writes.
    pub write: bool,
    /// What it is for.
    pub class: TrafficClass,
    /// Its size.
    pub bytes: u32,
    /// Whether the ray is marked.
    pub marked: bool,
    /// When the lines that were there are at hand.
    pub data_at: u64,
}

/// What became of a fetch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fetched {
    /// All lines are, or will be, there from that cycle on.
    At(u64),
    /// Some are on their way.
    Waits,
    /// No register, target or place to send a request is free: it stands at the head of the fetch queue.
    Stalled,
}

/// The unit.
#[derive(Clone, Debug)]
pub struct Station {
    cache: Cache,
    /// Rays that wait for the ports, and whether the first of them waits for a miss register, a target or a place instead.
    pub fetching: VecDeque<u32>,
    pub stalled: bool,
    /// Rays whose data are on their way from the L1, behind a line that comes.
    pub ready: u32,
    /// Rays whose line has come, which get it one a cycle; and whether they do.
    released: VecDeque<u32>,
    one_by_one: bool,
    /// Whether the unit is announced in the calendar.
    pub is_announced: bool,
    port_at: u64,
    port_used: u64,
    ports: u64,
    banks: BanksInUse,
    hit_latency: u64,
    begin_at: u64,
    latency: u64,
    interval: u64,
    pub writes: WritePolicy,
    operations: u64,
    requested: PerClass<Bytes>,
    written_through: PerClass<Past>,
    marked: PerClass<u64>,
}

impl Station {
    /// A unit of a kind, empty.
    pub fn new(spec: &KindSpec, line: u64) -> Self {
        Self {
            cache: spec.cache.build(line),
            fetching: VecDeque::new(),
            stalled: false,
            ready: 0,
            released: VecDeque::new(),
            one_by_one: spec.cache.release == Release::OneByOne,
            is_announced: false,
            port_at: 0,
            port_used: 0,
            ports: spec.cache.ports.get(),
            banks: BanksInUse::none(&spec.cache),
            hit_latency: spec.cache.latency.get(),
            begin_at: 0,
            latency: spec.latency,
            interval: spec.interval,
            writes: spec.writes,
            operations: 0,
            requested: PerClass::default(),
            written_through: PerClass::default(),
            marked: PerClass::default(),
        }
    }

    /// Whether a fetch can begin in cycle `now`, before all others.
    pub fn is_free(&self, now: u64) -> bool {
        self.port_at <= now && self.fetching.is_empty() && self.released.is_empty()
    }

    /// The cycle, `now` or a later one, in which the ports are free and someone waits for them.
    pub fn acts_at(&self, now: u64) -> Option<u64> {
        let waits = !self.released.is_empty() || !self.fetching.is_empty() && !self.stalled;
        waits.then_some(self.port_at.max(now))
    }

    /// The ray that gets its line in cycle `now`, in place of all accesses.
    pub fn release(&mut self, now: u64) -> Option<u32> {
        let ray = self.released.pop_front()?;
        self.turn_to(now + 1);
        Some(ray)
    }

    /// Goes on with a fetch in cycle `now`. `room` says whether a request could be sent; `miss` is told lines to ask for, and when, and says whether another
    /// could be.
    pub fn access(
        &mut self,
        ray: u32,
        fetch: &mut Fetch,
        now: u64,
        mut room: bool,
        mut miss: impl FnMut(LineAddr, u64) -> bool,
    ) -> Fetched {
        let access = self.writes.access(fetch.class, fetch.write);
        while fetch.left > 0 {
            if self.port_at < now {
                self.turn_to(now);
            }
            if !self.banks.take(fetch.line, fetch.class) {
                self.turn_to(self.port_at + 1);
                continue;
            }
            match self.cache.access(fetch.line, fetch.class, access, Some(ray), room) {
                Lookup::Stalled => return Fetched::Stalled,
                Lookup::Passed => unreachable!("a ray waits for the data"),
                Lookup::Hit => fetch.data_at = self.port_at + self.hit_latency,
                Lookup::Merged => fetch.missing += 1,
                Lookup::Miss => {
                    fetch.missing += 1;
                    self.marked[fetch.class as usize] += u64::from(fetch.marked);
                    room = miss(fetch.line, self.port_at);
                }
            }
            self.port_used += 1;
            if self.port_used == self.ports {
                self.turn_to(self.port_at + 1);
            }
            fetch.line.0 += 1;
            fetch.left -= 1;
        }
        self.requested[fetch.class as usize] += Bytes(fetch.bytes.into());
        if fetch.missing == 0 { Fetched::At(fetch.data_at) } else { Fetched::Waits }
    }

    /// The ports and banks are free from cycle `at` on.
    fn turn_to(&mut self, at: u64) {
        (self.port_at, self.port_used) = (at, 0);
        self.banks.clear();
    }

    /// An operation begins as soon as it can from cycle `at` on; gives when it begins.
    pub fn operate(&mut self, at: u64) -> u64 {
        let begin = at.max(self.begin_at);
        self.begin_at = begin + self.interval;
        self.operations += 1;
        begin
    }

    /// When an operation that begins in cycle `begin` ends.
    pub fn end(&self, begin: u64) -> u64 {
        begin + self.latency
    }

    /// A write goes through.
    pub fn write_through(&mut self, class: TrafficClass, bytes: Bytes) {
        let through = &mut self.written_through[class as usize];
        through.count += 1;
        through.bytes += bytes;
    }

    /// A line comes; rays that wait for it and get it now are appended to `waiting`. Gives a dirty line that goes.
    pub fn fill(&mut self, line: LineAddr, waiting: &mut Vec<u32>) -> Option<(LineAddr, TrafficClass)> {
        self.stalled = false;
        let filled = self.cache.fill(line, true, waiting);
        if self.one_by_one {
            self.released.extend(waiting.drain(..));
        }
        match filled {
            Fill::Done { victim } => victim.map(|victim| (victim.line, victim.class)),
            Fill::Blocked => unreachable!("there is always room"),
        }
    }

    /// The L1 holds from now on what `cache` does.
    pub fn hold(&mut self, cache: &Cache) {
        self.cache.hold(cache);
    }

    /// A frame begins: lines from `first` on go.
    pub fn drop_from(&mut self, first: LineAddr) {
        self.cache.drop_from(first);
    }

    /// Misses under way.
    pub fn misses_under_way(&self) -> usize {
        self.cache.misses_under_way()
    }

    /// What was counted: no cause but `Busy` is known.
    pub fn tally(&self) -> UnitTally {
        UnitTally {
            causes: busy(self.operations * self.interval),
            cache: *self.cache.counts(),
            l1: *self.banks.counts(),
            requested: self.requested,
            written_through: self.written_through,
            read_straight: PerClass::default(),
            marked: self.marked,
        }
    }
}
