//! What all units that work on rays have in common: an L1, rays that wait for their data, and a pipeline.

use super::causes::Causes;
use super::links::{Answer, Links, take};
use super::ray::{Fetch, Ray, RayId};
use crate::machine::layout::{Element, Layout};
use crate::machine::writes::WritePolicy;
use crate::memory::cache::{Access, BanksInUse, Cache, CacheSpec, Fill, Lookup, Past, Release};
use crate::memory::ring::Ring;
use crate::memory::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{Cause, TrafficClass};

/// The timing of a unit's pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Stages {
    /// Cycles that an operation takes.
    pub latency: u64,
    /// Cycles from an operation to the next.
    pub interval: u64,
    /// Operations that begin at once.
    pub width: u64,
}

/// What became of the requests of a cycle.
#[derive(Clone, Copy, Debug)]
struct Passage {
    /// Whether the fetch queue was stopped.
    stalled: bool,
    /// Whether a request found a place in the L2.
    sent: bool,
}

/// The common part of a unit. The unit calls [`Pipeline::arrive`], [`Pipeline::leave`], [`Pipeline::begin`] and
/// [`Pipeline::end`] in this order, once in every cycle in which it acts.
#[derive(Clone, Debug)]
pub struct Pipeline {
    part: PartId,
    core: u32,
    cache: Cache,
    out: Ring<Request>,
    out_places: usize,
    ports: u64,
    banks: BanksInUse,
    hit_latency: u64,
    timing: Stages,
    /// The first cycle in which an operation can begin.
    open_at: u64,
    line: Bytes,
    writes: WritePolicy,
    fetching: Ring<RayId>,
    hits: Ring<(u64, RayId)>,
    /// Rays that made all their accesses and wait for lines.
    waiting: usize,
    ready: Ring<RayId>,
    /// Rays in the pipeline, with the cycles in which their operations end. The last may begin only in the next cycle.
    stages: Ring<(u64, RayId)>,
    requested: [Bytes; TrafficClass::ALL.len()],
    written_through: [Past; TrafficClass::ALL.len()],
    causes: Causes,
    filled: bool,
    /// Whether a line was accessed in this cycle. That may have made another line, a clean one, the next to go, or given the line that
    /// waits a place: a fill that waits can be made then.
    accessed: bool,
    /// Whether the access of this cycle is a hit whose operation begins in the next one.
    begins_next: bool,
    filled_for: Vec<RayId>,
    release: Release,
    /// Rays whose lines have come and are given out one by one.
    released: Ring<RayId>,
    /// Requests under way past the L1, the oldest first, and how many there can be.
    straight: Ring<(LineAddr, RayId)>,
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
            out: Ring::new(),
            out_places: cache.queue.size(),
            ports: cache.ports.get(),
            banks: BanksInUse::none(cache),
            hit_latency: cache.latency.get(),
            timing,
            open_at: 0,
            line: Bytes(line),
            writes,
            fetching: Ring::new(),
            hits: Ring::new(),
            waiting: 0,
            ready: Ring::new(),
            stages: Ring::new(),
            requested: [Bytes(0); TrafficClass::ALL.len()],
            written_through: [Past::default(); TrafficClass::ALL.len()],
            causes: Causes::default(),
            filled: false,
            accessed: false,
            begins_next: false,
            filled_for: Vec::new(),
            release: cache.release,
            released: Ring::new(),
            straight: Ring::new(),
            most_straight: cache.mshrs.size(),
            read_straight: [Past::default(); TrafficClass::ALL.len()],
            marked: [0; TrafficClass::ALL.len()],
        }
    }

    /// The unit's number in the machine.
    #[inline]
    pub fn part(&self) -> PartId {
        self.part
    }

    /// The unit's core.
    #[inline]
    pub fn core(&self) -> u32 {
        self.core
    }

    /// Steps 1 and 2 of a cycle: a fill, and hits that get their line.
    #[inline]
    pub fn arrive(&mut self, now: u64, links: &mut Links) {
        self.filled = links.line_is_there(self.part, now) && self.fill(links);
        while let Some(ray) = take(&mut self.hits, now) {
            self.line_came(ray, &mut links.rays);
        }
    }

    /// Step 1, of a line that is there; whether it was taken.
    fn fill(&mut self, links: &mut Links) -> bool {
        let lines = &mut links.lines[self.part.0 as usize];
        let Some(&Answer { line, .. }) = lines.front() else { return false };
        let past = self.straight.iter().position(|(asked, _)| *asked == line);
        if let Some(at) = past {
            lines.drop_front();
            if let Some((_, ray)) = self.straight.remove(at) {
                self.line_came(ray, &mut links.rays);
            }
            return true;
        }
        self.filled_for.clear();
        let room = self.out.len() < self.out_places;
        let Fill::Done { victim } = self.cache.fill(line, room, &mut self.filled_for) else { return false };
        lines.drop_front();
        if let Some(victim) = victim {
            self.push_out(victim.line, victim.class, true, self.line);
        }
        match self.release {
            Release::Together => {
                for index in 0..self.filled_for.len() {
                    self.line_came(self.filled_for[index], &mut links.rays);
                }
            }
            // The row stays in use until its last ray has left: which no access sees, since none is made until then.
            Release::OneByOne => self.released.extend(self.filled_for.drain(..)),
        }
        true
    }

    #[inline]
    fn line_came(&mut self, ray: RayId, rays: &mut [Ray]) {
        let fetch = &mut rays[ray as usize].fetch;
        fetch.missing -= 1;
        if fetch.missing == 0 && fetch.left == 0 {
            self.waiting -= 1;
            self.ready.push_back(ray);
        }
    }

    /// Step 3: the ray whose operation ends.
    #[inline]
    pub fn leave(&mut self, now: u64) -> Option<RayId> {
        take(&mut self.stages, now)
    }

    /// The ray whose operation ends, if all other rays of the unit are in the pipeline or wait for lines from the L2.
    #[inline]
    pub fn leaves_alone(&self, now: u64) -> Option<RayId> {
        let queued = self.fetching.len() | self.hits.len() | self.ready.len() | self.out.len() | self.released.len();
        let &(at, ray) = self.stages.front()?;
        (at == now && queued == 0).then_some(ray)
    }

    /// The whole cycle of a unit that [leaves](Pipeline::leaves_alone) a ray alone, if the ray fetches `element` next, to which an L1 without
    /// banks gives one access: if the element lies in one line, which is there, its operation begins in the next cycle. No line comes
    /// before. Returns when the next operation ends; `None` if it is not so, and nothing was done.
    #[inline]
    pub fn fetch_at_once(&mut self, ray: RayId, element: &Element, layout: &Layout, now: u64) -> Option<u64> {
        let (line, lines) = layout.lines(element);
        if lines > 1 || self.hit_latency > 1 || self.open_at > now + 1 {
            return None;
        }
        if !self.cache.hit(line, element.class, Access::Read) {
            return None;
        }
        self.requested[element.class as usize] += Bytes(element.bytes);
        self.stages.drop_front();
        self.enter(ray, now + 1);
        self.causes.cycle(now, 0, Cause::Memory);
        self.causes.ahead(now + 1, self.timing.interval, self.idle_cause(false));
        self.stages.front().map(|stage| stage.0)
    }

    /// A ray begins to fetch `element`.
    #[inline]
    pub fn fetch(&mut self, ray: RayId, element: &Element, links: &mut Links) {
        links.rays[ray as usize].begin_fetch(element, &links.layout);
        self.fetching.push_back(ray);
    }

    /// A ray begins to fetch `element` from the L2.
    pub fn fetch_straight(&mut self, ray: RayId, element: &Element, links: &mut Links) {
        self.fetch(ray, element, links);
        links.rays[ray as usize].fetch.straight = true;
    }

    /// A ray is to take an operation that writes `element`, without a fetch.
    pub fn ready_to_write(&mut self, ray: RayId, element: &Element, links: &mut Links) {
        links.rays[ray as usize].begin_fetch(element, &links.layout);
        self.ready.push_back(ray);
    }

    /// A ray is to take an operation without a fetch.
    pub fn ready(&mut self, ray: RayId, links: &mut Links) {
        links.rays[ray as usize].fetch.write = false;
        self.ready.push_back(ray);
    }

    /// Step 5: whether an operation began.
    #[inline]
    pub fn begin(&mut self, now: u64, rays: &[Ray]) -> bool {
        now >= self.open_at && self.begin_first(now, rays)
    }

    /// Step 5 of a unit in which several operations can begin at once: whether any did.
    pub fn begin_several(&mut self, now: u64, rays: &[Ray]) -> bool {
        let began = self.begin(now, rays);
        if began {
            (1..self.timing.width).take_while(|_| self.begin_first(now, rays)).for_each(drop);
        }
        began
    }

    /// The first ray of the ready list begins its operation, if nothing is missing.
    #[inline]
    fn begin_first(&mut self, now: u64, rays: &[Ray]) -> bool {
        let Some(&ray) = self.ready.front() else { return false };
        let fetch = &rays[ray as usize].fetch;
        if fetch.write && self.writes.go_through(fetch.class) && !self.write_through(fetch) {
            return false;
        }
        self.ready.drop_front();
        self.enter(ray, now);
        true
    }

    /// An operation of `ray` begins in cycle `at`.
    #[inline]
    fn enter(&mut self, ray: RayId, at: u64) {
        self.stages.push_back((at + self.timing.latency, ray));
        self.open_at = at + self.timing.interval;
    }

    /// Sends the write of an operation down, if there is a place.
    fn write_through(&mut self, fetch: &Fetch) -> bool {
        if self.out.len() == self.out_places {
            return false;
        }
        // An entry of a store lies in one line.
        let bytes = Bytes(fetch.bytes.into());
        self.push_out(fetch.first, fetch.class, true, bytes);
        self.written_through[fetch.class as usize].add(bytes);
        true
    }

    /// Steps 6 and 7, and the account of the cycle: `began` is what [`Pipeline::begin`] said, `leaving` whether a ray waits
    /// to go to another unit.
    #[inline]
    pub fn end(&mut self, now: u64, links: &mut Links, began: bool, leaving: bool) {
        let passage = self.pass_down(now, links);
        self.account(now, began, leaving || !self.ready.is_empty());
        self.announce(now, links, passage);
    }

    /// As [`Pipeline::end`], of a cycle in which the unit took as many rays as it can and others waited.
    pub fn end_full(&mut self, now: u64, links: &mut Links, began: bool, leaving: bool) {
        let passage = self.pass_down(now, links);
        let held = leaving || !self.ready.is_empty();
        if began {
            self.account(now, began, held);
        } else {
            self.account_passed_by(now, held);
        }
        self.announce(now, links, passage);
    }

    /// Steps 6 and 7.
    #[inline]
    fn pass_down(&mut self, now: u64, links: &mut Links) -> Passage {
        (self.accessed, self.begins_next) = (false, false);
        let stalled = self.access(now, links);
        let sent = !self.out.is_empty() && self.send(now, links);
        Passage { stalled, sent }
    }

    /// Announces the next cycle in which the unit has something to do.
    #[inline]
    fn announce(&mut self, now: u64, links: &mut Links, Passage { stalled, sent }: Passage) {
        let lines = links.lines[self.part.0 as usize].front().map_or(u64::MAX, |line| line.at);
        let at_once = !self.released.is_empty()
            || !self.fetching.is_empty() && (!stalled || sent)
            || !self.out.is_empty() && sent
            || lines <= now && (self.filled || sent || self.accessed);
        let at = if at_once { now + 1 } else { self.next_event(now, lines) };
        if at != u64::MAX {
            links.clock.wake(self.part, at);
        }
    }

    /// The next cycle in which something happens that is known: [`u64::MAX`] if nothing is. `lines` is when the first line comes.
    #[inline]
    fn next_event(&self, now: u64, lines: u64) -> u64 {
        let begin = if self.ready.is_empty() { u64::MAX } else { self.open_at.max(now + 1) };
        let line = if lines > now { lines } else { u64::MAX };
        let hit = self.hits.front().map_or(u64::MAX, |hit| hit.0);
        let stage = self.stages.front().map_or(u64::MAX, |stage| stage.0);
        begin.min(line).min(hit).min(stage)
    }

    /// Why no operation begins while nothing happens; `held` says whether a ray waits for a place in the pipeline or elsewhere.
    #[inline]
    fn idle_cause(&self, held: bool) -> Cause {
        if held {
            Cause::Blocked
        } else if !self.fetching.is_empty() || self.waiting > 0 {
            Cause::Memory
        } else if !self.stages.is_empty() {
            Cause::Pipeline
        } else {
            Cause::Starved
        }
    }

    /// Counts the cycle by its cause; `held` says whether a ray waits for a place in the pipeline or elsewhere.
    #[inline]
    fn account(&mut self, now: u64, began: bool, held: bool) {
        let idle = self.idle_cause(held);
        let occupied = if began { self.timing.interval } else { 0 };
        if self.begins_next {
            // In this cycle its ray waits for the line.
            self.causes.cycle(now, occupied, if held { Cause::Blocked } else { Cause::Memory });
            self.causes.ahead(now + 1, self.timing.interval, idle);
        } else {
            self.causes.cycle(now, occupied, idle);
        }
    }

    /// Counts a cycle in which no operation began and rays had to wait at the intake.
    fn account_passed_by(&mut self, now: u64, held: bool) {
        let idle = self.idle_cause(held);
        self.causes.passed_by(now, idle);
        if self.begins_next {
            self.causes.ahead(now + 1, self.timing.interval, idle);
        }
    }

    /// Step 6; whether the queue was stopped.
    #[inline]
    fn access(&mut self, now: u64, links: &mut Links) -> bool {
        if let Some(ray) = self.released.pop_front() {
            self.line_came(ray, &mut links.rays);
            return false;
        }
        self.banks.clear();
        for _ in 0..self.ports {
            let Some(&ray) = self.fetching.front() else { return false };
            let fetch = links.rays[ray as usize].fetch;
            if fetch.straight {
                if !self.ask_straight(ray, &mut links.rays) {
                    return true;
                }
                continue;
            }
            if !self.banks.take(fetch.line) {
                self.cache.conflict(fetch.class);
                return false;
            }
            let access = self.writes.access(fetch.class, fetch.write);
            let hit = self.cache.hit(fetch.line, fetch.class, access);
            if !hit && !self.miss(ray, access, &mut links.rays) {
                return true;
            }
            self.accessed = true;
            let fetch = &mut links.rays[ray as usize].fetch;
            fetch.line.0 += 1;
            fetch.left -= 1;
            if fetch.left > 0 {
                // With a latency of one cycle, the line is there when the next one is accessed.
                if !hit || self.hit_latency > 1 {
                    self.wait(ray, hit, now, fetch);
                }
                continue;
            }
            self.requested[fetch.class as usize] += Bytes(fetch.bytes.into());
            self.fetching.drop_front();
            let alone = hit && fetch.missing == 0 && !(fetch.write && self.writes.go_through(fetch.class));
            if alone && self.is_open_next(now, links.lines[self.part.0 as usize].front()) {
                self.enter(ray, now + 1);
                self.begins_next = true;
            } else {
                self.waiting += 1;
                self.wait(ray, hit, now, fetch);
            }
        }
        false
    }

    /// A ray waits for a line that it accessed.
    #[inline]
    fn wait(&mut self, ray: RayId, hit: bool, now: u64, fetch: &mut Fetch) {
        fetch.missing += 1;
        if hit {
            self.hits.push_back((now + self.hit_latency, ray));
        }
    }

    /// Whether a ray that gets its last line in the next cycle, as a hit of this one, begins its operation then: it does if it is the first of
    /// the ready list, and no other can begin beside it. `line` is the first to come from the L2: of those that
    /// come in the next cycle all are known, since an answer takes the L2's latency.
    #[inline]
    fn is_open_next(&self, now: u64, line: Option<&Answer>) -> bool {
        self.hit_latency == 1
            && self.timing.width == 1
            && self.open_at <= now + 1
            && self.ready.is_empty()
            && self.hits.is_empty()
            && line.is_none_or(|line| line.at > now + 1)
    }

    /// An access of `ray` to a line that is not there; false if it has to wait.
    fn miss(&mut self, ray: RayId, access: Access, rays: &mut [Ray]) -> bool {
        let Ray { marked, fetch: Fetch { line, class, .. }, .. } = rays[ray as usize];
        let room = self.out.len() < self.out_places;
        match self.cache.miss(line, class, access, Some(ray), room) {
            Lookup::Stalled => return false,
            Lookup::Hit | Lookup::Passed => unreachable!("the line is not there, and a ray waits for the data"),
            Lookup::Merged => {}
            Lookup::Miss => {
                self.marked[class as usize] += u64::from(marked);
                let bytes = self.line;
                self.out.push_back(Request { line, class, write: false, bytes, from: self.part, marked });
            }
        }
        true
    }

    /// The first ray of the fetch queue asks the L2 for its line; false if it has to wait.
    fn ask_straight(&mut self, ray: RayId, rays: &mut [Ray]) -> bool {
        if self.out.len() == self.out_places || self.straight.len() == self.most_straight {
            return false;
        }
        let marked = rays[ray as usize].marked;
        let fetch = &mut rays[ray as usize].fetch;
        let (line, class, bytes) = (fetch.line, fetch.class, Bytes(fetch.bytes.into()));
        (fetch.left, fetch.missing) = (0, 1);
        self.out.push_back(Request { line, class, write: false, bytes, from: self.part, marked });
        self.straight.push_back((line, ray));
        self.read_straight[class as usize].add(bytes);
        self.waiting += 1;
        self.fetching.drop_front();
        true
    }

    fn push_out(&mut self, line: LineAddr, class: TrafficClass, write: bool, bytes: Bytes) {
        self.out.push_back(Request { line, class, write, bytes, from: self.part, marked: false });
    }

    /// Step 7; whether the first of the out queue found a place.
    fn send(&mut self, now: u64, links: &mut Links) -> bool {
        let sent = self.out.front().is_some_and(|&request| links.l2.put(self.core, request, now, &mut links.clock));
        if sent {
            self.out.drop_front();
        }
        sent
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
