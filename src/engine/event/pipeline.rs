//! What all units that work on rays have in common: an L1, rays that wait for their data, and a pipeline.

use std::collections::VecDeque;

use super::causes::Causes;
use super::links::{Links, take};
use super::ray::{Ray, RayId};
use crate::machine::layout::Element;
use crate::machine::writes::WritePolicy;
use crate::memory::cache::{BanksInUse, Cache, CacheSpec, Fill, Lookup, Past, Release};
use crate::memory::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{Cause, L1Counts, TrafficClass};

/// The timing of a unit's pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Stages {
    /// Cycles that an operation takes.
    pub latency: u64,
    /// Cycles from an operation to the next.
    pub interval: u64,
}

/// The common part of a unit. The unit calls [`Pipeline::arrive`], [`Pipeline::leave`], [`Pipeline::begin`] and
/// [`Pipeline::end`] in this order, once in every cycle in which it acts.
#[derive(Clone, Debug)]
pub struct Pipeline {
    part: PartId,
    core: u32,
    cache: Cache,
    out: VecDeque<Request>,
    out_places: usize,
    ports: u64,
    banks: BanksInUse,
    hit_latency: u64,
    timing: Stages,
    /// The first cycle in which an operation can begin.
    open_at: u64,
    line: Bytes,
    writes: WritePolicy,
    fetching: VecDeque<RayId>,
    hits: VecDeque<(u64, RayId)>,
    /// Rays that made all their accesses and wait for lines.
    waiting: usize,
    ready: VecDeque<RayId>,
    stages: VecDeque<(u64, RayId)>,
    requested: [Bytes; TrafficClass::ALL.len()],
    written_through: [Past; TrafficClass::ALL.len()],
    causes: Causes,
    filled: bool,
    /// Whether a line was accessed in this cycle. That may have made another line, a clean one, the next to go, or given the line that
    /// waits a place: a fill that waits can be made then.
    accessed: bool,
    filled_for: Vec<RayId>,
    release: Release,
    /// Rays whose lines have come and are given out one by one.
    released: VecDeque<RayId>,
    /// Requests under way past the L1, the oldest first, and how many there can be.
    straight: VecDeque<(LineAddr, RayId)>,
    most_straight: usize,
    read_straight: [Past; TrafficClass::ALL.len()],
    /// Misses of marked rays.
    marked: [u64; TrafficClass::ALL.len()],
}

impl Pipeline {
    /// An empty unit with the number `part`, of a core, whose L1 has lines of `line` bytes.
    pub fn new(part: PartId, core: u32, cache: &CacheSpec, timing: Stages, line: u64, writes: WritePolicy) -> Self {
        Self {
            part,
            core,
            cache: cache.build(line),
            out: VecDeque::with_capacity(cache.queue.size()),
            out_places: cache.queue.size(),
            ports: cache.ports.get(),
            banks: BanksInUse::none(cache),
            hit_latency: cache.latency.get(),
            timing,
            open_at: 0,
            line: Bytes(line),
            writes,
            fetching: VecDeque::new(),
            hits: VecDeque::new(),
            waiting: 0,
            ready: VecDeque::new(),
            stages: VecDeque::new(),
            requested: [Bytes(0); TrafficClass::ALL.len()],
            written_through: [Past::default(); TrafficClass::ALL.len()],
            causes: Causes::default(),
            filled: false,
            accessed: false,
            filled_for: Vec::new(),
            release: cache.release,
            released: VecDeque::new(),
            straight: VecDeque::new(),
            most_straight: cache.mshrs.size(),
            read_straight: [Past::default(); TrafficClass::ALL.len()],
            marked: [0; TrafficClass::ALL.len()],
        }
    }

    /// The unit's number in the machine.
    pub fn part(&self) -> PartId {
        self.part
    }

    /// The unit's core.
    pub fn core(&self) -> u32 {
        self.core
    }

    /// Steps 1 and 2 of a cycle: a fill, and hits that get their line.
    pub fn arrive<W>(&mut self, now: u64, links: &mut Links<W>) {
        self.filled = self.fill(now, links);
        while let Some(ray) = take(&mut self.hits, now) {
            self.line_came(ray, &mut links.rays);
        }
    }

    /// Step 1; whether a line was taken.
    fn fill<W>(&mut self, now: u64, links: &mut Links<W>) -> bool {
        let lines = &mut links.lines[self.part.0 as usize];
        let Some(&(_, line)) = lines.front().filter(|(at, _)| *at <= now) else { return false };
        self.filled_for.clear();
        if let Some(at) = self.straight.iter().position(|(asked, _)| *asked == line) {
            let ray = self.straight.remove(at).map(|(_, ray)| ray);
            lines.pop_front();
            ray.into_iter().for_each(|ray| self.line_came(ray, &mut links.rays));
        } else {
            let room = self.out.len() < self.out_places;
            let Fill::Done { victim } = self.cache.fill(line, room, &mut self.filled_for) else { return false };
            if let Some(victim) = victim {
                self.push_out(victim.line, victim.class, true, self.line);
            }
            lines.pop_front();
            match self.release {
                Release::Together => {
                    for index in 0..self.filled_for.len() {
                        self.line_came(self.filled_for[index], &mut links.rays);
                    }
                }
                // The row stays in use until its last ray has left: which no access sees, since none is made until then.
                Release::OneByOne => self.released.extend(self.filled_for.drain(..)),
            }
        }
        true
    }

    fn line_came(&mut self, ray: RayId, rays: &mut [Ray]) {
        let fetch = &mut rays[ray as usize].fetch;
        fetch.missing -= 1;
        if fetch.missing == 0 && fetch.left == 0 {
            self.waiting -= 1;
            self.ready.push_back(ray);
        }
    }

    /// Step 3: the ray whose operation ends.
    pub fn leave(&mut self, now: u64) -> Option<RayId> {
        take(&mut self.stages, now)
    }

    /// A ray begins to fetch `element`.
    pub fn fetch<W>(&mut self, ray: RayId, element: &Element, links: &mut Links<W>) {
        links.rays[ray as usize].begin_fetch(element, &links.layout);
        self.fetching.push_back(ray);
    }

    /// A ray begins to fetch `element` from the L2.
    pub fn fetch_straight<W>(&mut self, ray: RayId, element: &Element, links: &mut Links<W>) {
        self.fetch(ray, element, links);
        links.rays[ray as usize].fetch.straight = true;
    }

    /// A ray is to take an operation that writes `element`, without a fetch.
    pub fn ready_to_write<W>(&mut self, ray: RayId, element: &Element, links: &mut Links<W>) {
        links.rays[ray as usize].begin_fetch(element, &links.layout);
        self.ready.push_back(ray);
    }

    /// A ray is to take an operation without a fetch.
    pub fn ready(&mut self, ray: RayId, links: &mut Links<impl Wake>) {
        links.rays[ray as usize].fetch.write = false;
        self.ready.push_back(ray);
    }

    /// Step 5: whether an operation began.
    pub fn begin(&mut self, now: u64, rays: &[Ray]) -> bool {
        let Some(&ray) = self.ready.front().filter(|_| now >= self.open_at) else { return false };
        let fetch = &rays[ray as usize].fetch;
        if fetch.write && self.writes.go_through(fetch.class) {
            if self.out.len() == self.out_places {
                return false;
            }
            // An entry of a store lies in one line.
            let bytes = Bytes(fetch.bytes.into());
            self.push_out(fetch.first, fetch.class, true, bytes);
            let through = &mut self.written_through[fetch.class as usize];
            through.count += 1;
            through.bytes += bytes;
        }
        self.ready.pop_front();
        self.stages.push_back((now + self.timing.latency, ray));
        self.open_at = now + self.timing.interval;
        true
    }

    /// Steps 6 and 7, and the account of the cycle: `began` is what [`Pipeline::begin`] said, `leaving` whether a ray waits
    /// to go to another unit.
    pub fn end(&mut self, now: u64, links: &mut Links<impl Wake>, began: bool, leaving: bool) {
        self.accessed = false;
        let stalled = self.access(now, &mut links.rays);
        let sent = self.out.front().is_some_and(|&request| links.l2.put(self.core, request, now, &mut links.clock));
        if sent {
            self.out.pop_front();
        }
        self.causes.cycle(now, if began { self.timing.interval } else { 0 }, self.idle_cause(leaving));

        let lines = links.lines[self.part.0 as usize].front().map(|line| line.0);
        let at_once = !self.released.is_empty()
            || !self.fetching.is_empty() && (!stalled || sent)
            || !self.out.is_empty() && sent
            || lines.is_some_and(|at| at <= now) && (self.filled || sent || self.accessed);
        if at_once {
            links.clock.wake(self.part, now + 1);
            return;
        }
        let begin = (!self.ready.is_empty()).then_some(self.open_at.max(now + 1));
        let stamps = [begin, lines, self.hits.front().map(|hit| hit.0), self.stages.front().map(|stage| stage.0)];
        if let Some(at) = stamps.into_iter().flatten().filter(|&at| at > now).min() {
            links.clock.wake(self.part, at);
        }
    }

    /// Step 6; whether the queue was stopped.
    fn access(&mut self, now: u64, rays: &mut [Ray]) -> bool {
        if let Some(ray) = self.released.pop_front() {
            self.line_came(ray, rays);
            return false;
        }
        self.banks.clear();
        for _ in 0..self.ports {
            let Some(&ray) = self.fetching.front() else { return false };
            let marked = rays[ray as usize].marked;
            let fetch = &mut rays[ray as usize].fetch;
            let access = self.writes.access(fetch.class, fetch.write);
            let room = self.out.len() < self.out_places;
            if fetch.straight {
                if !room || self.straight.len() == self.most_straight {
                    return true;
                }
                let (line, class, bytes) = (fetch.line, fetch.class, Bytes(fetch.bytes.into()));
                (fetch.left, fetch.missing) = (0, 1);
                self.out.push_back(Request { line, class, write: false, bytes, from: self.part, marked });
                self.straight.push_back((line, ray));
                self.read_straight[class as usize].count += 1;
                self.read_straight[class as usize].bytes += bytes;
                self.waiting += 1;
                self.fetching.pop_front();
                continue;
            }
            if !self.banks.take(fetch.line, fetch.class) {
                return false;
            }
            let lookup = self.cache.access(fetch.line, fetch.class, access, Some(ray), room);
            match lookup {
                Lookup::Stalled => return true,
                Lookup::Passed => unreachable!("a ray waits for the data"),
                Lookup::Hit => self.hits.push_back((now + self.hit_latency, ray)),
                Lookup::Merged => {}
                Lookup::Miss => {
                    let (line, class) = (fetch.line, fetch.class);
                    self.marked[class as usize] += u64::from(marked);
                    let bytes = self.line;
                    self.out.push_back(Request { line, class, write: false, bytes, from: self.part, marked });
                }
            }
            self.accessed = true;
            fetch.line.0 += 1;
            fetch.left -= 1;
            fetch.missing += 1;
            if fetch.left == 0 {
                self.requested[fetch.class as usize] += Bytes(fetch.bytes.into());
                self.waiting += 1;
                self.fetching.pop_front();
            }
        }
        false
    }

    fn push_out(&mut self, line: LineAddr, class: TrafficClass, write: bool, bytes: Bytes) {
        self.out.push_back(Request { line, class, write, bytes, from: self.part, marked: false });
    }

    fn idle_cause(&self, leaving: bool) -> Cause {
        let memory = !self.fetching.is_empty() || self.waiting > 0;
        let pipeline = !self.stages.is_empty();
        if leaving || !self.ready.is_empty() {
            Cause::Blocked
        } else if memory {
            Cause::Memory
        } else if pipeline {
            Cause::Pipeline
        } else {
            Cause::Starved
        }
    }

    /// A frame begins: lines from `first` on go.
    pub fn drop_from(&mut self, first: LineAddr) {
        self.cache.drop_from(first);
    }

    /// The L1 holds from now on what `cache` does.
    pub fn hold(&mut self, cache: &Cache) {
        self.cache.hold(cache);
    }

    /// Whether nothing is on its way to the L2.
    pub fn is_idle(&self) -> bool {
        self.out.is_empty() && self.cache.misses_under_way() == 0 && self.straight.is_empty()
    }

    /// The L1.
    pub fn cache(&self) -> &Cache {
        &self.cache
    }

    /// Bytes that the unit asked its L1 for, by class.
    pub fn requested(&self) -> &[Bytes; TrafficClass::ALL.len()] {
        &self.requested
    }

    /// Writes that went through, by class.
    pub fn written_through(&self) -> &[Past; TrafficClass::ALL.len()] {
        &self.written_through
    }

    /// Reads that went past the L1, by class.
    pub fn read_straight(&self) -> &[Past; TrafficClass::ALL.len()] {
        &self.read_straight
    }

    /// What its L1 alone counted, by class.
    pub fn l1_counts(&self) -> &[L1Counts; TrafficClass::ALL.len()] {
        self.banks.counts()
    }

    /// Misses of marked rays, by class.
    pub fn marked(&self) -> &[u64; TrafficClass::ALL.len()] {
        &self.marked
    }

    /// The unit's cycles.
    pub fn causes(&self) -> &Causes {
        &self.causes
    }

    /// The state of the queues, for the report of a deadlock.
    pub fn queues(&self) -> String {
        format!(
            "to fetch {}, waiting for lines {}, ready {}, in the pipeline {}, misses under way {}, out {}/{}",
            self.fetching.len(),
            self.waiting,
            self.ready.len(),
            self.stages.len(),
            self.cache.misses_under_way(),
            self.out.len(),
            self.out_places
        )
    }
}
