//! What all units that work on rays have in common: an L1, rays that wait for their data, and a pipeline.

use super::causes::Causes;
use super::links::{Answer, Links, take};
use super::ray::{Fetch, Ray, RayId};
use crate::machine::MachineSpec;
use crate::machine::layout::Element;
use crate::machine::writes::WritePolicy;
use crate::memory::cache::{Access, BanksInUse, Cache, CacheSpec, Fill, Lookup, Past, Release};
use crate::memory::ring::Ring;
use crate::memory::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{Cause, L1Counts, TrafficClass};

/// The timing of a unit's pipeline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stages {
    /// Cycles that an operation takes.
    pub latency: u64,
    /// Cycles from an operation to the next.
    pub interval: u64,
    /// Operations that begin at once.
    pub width: u64,
}

/// What a unit knows of the memory below its L1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Memory {
    /// Bytes of a line.
    pub line: u64,
    /// The shortest latency of a cache of the L2.
    pub answer_latency: u64,
}

impl Memory {
    /// Of `machine`.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        let latencies = machine.l2.caches().into_iter().map(|(_, cache)| cache.latency.get());
        Self { line: machine.line_bytes.get(), answer_latency: latencies.min().unwrap_or(0) }
    }
}

/// The common part of a unit. The unit calls [`Pipeline::arrive`], [`Pipeline::leave`], [`Pipeline::begin`] and
/// [`Pipeline::end`] in this order, once in every cycle in which it acts.
#[derive(Clone, Debug)]
pub(crate) struct Pipeline {
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
    /// Whether the first of the fetch queue found no register, target or place: until a line comes or a request goes, it finds none.
    stuck: bool,
    /// Whether a line was accessed in this cycle. That may have made another line, a clean one, the next to go, or given the line that
    /// waits a place: a fill that waits can be made then.
    accessed: bool,
    /// Whether hits are foreseen ([`Pipeline::foresee`]), and after how many cycles the L2 answers at the earliest.
    foresees: bool,
    answer_latency: u64,
    /// The first cycle in which the port of the L1 is free.
    access_at: u64,
    /// When the last operation begins of those that were entered ahead.
    begins_last: u64,
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
    /// An empty unit with the number `part`, of a core.
    pub(crate) fn new(
        part: PartId,
        core: u32,
        cache: &CacheSpec,
        timing: Stages,
        writes: WritePolicy,
        memory: Memory,
    ) -> Self {
        let Memory { line, answer_latency } = memory;
        let one_a_cycle = cache.ports.get() == 1 && timing.interval == 1 && timing.width == 1;
        let foresees = one_a_cycle && cache.latency.get() == 1 && writes == WritePolicy::Back;
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
            stuck: false,
            accessed: false,
            foresees,
            answer_latency,
            access_at: 0,
            begins_last: 0,
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
    pub(crate) fn part(&self) -> PartId {
        self.part
    }

    /// The unit's core.
    #[inline]
    pub(crate) fn core(&self) -> u32 {
        self.core
    }

    /// Steps 1 and 2 of a cycle: a fill, and hits that get their line.
    #[inline]
    pub(crate) fn arrive(&mut self, now: u64, links: &mut Links) {
        self.filled = links.line_is_there(self.part, now) && self.fill(links);
        self.stuck &= !self.filled;
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
    pub(crate) fn leave(&mut self, now: u64) -> Option<RayId> {
        take(&mut self.stages, now)
    }

    /// Hits are not foreseen any more: for a unit in which rays get ready without a fetch, or whose caches can be replaced while it works.
    pub(crate) fn foresee_nothing(&mut self) {
        self.foresees = false;
    }

    /// A ray begins to fetch `element`.
    #[inline]
    pub(crate) fn fetch(&mut self, ray: RayId, element: &Element, now: u64, links: &mut Links) {
        let mut fetch = Fetch::of(element, &links.layout);
        if self.foresees && self.queued() == 0 {
            let bound = self.first_unknown(now, links);
            if self.foresee(ray, &mut fetch, now, bound) {
                return;
            }
        }
        links.rays[ray as usize].fetch = fetch;
        self.fetching.push_back(ray);
    }

    /// Entries of all queues and lists that an access or an operation waits in.
    #[inline]
    fn queued(&self) -> usize {
        self.fetching.len() | self.hits.len() | self.ready.len() | self.released.len()
    }

    /// The first cycle in which a line may come from the L2: those on their way are known, others take the L2's latency.
    #[inline]
    fn first_unknown(&self, now: u64, links: &Links) -> u64 {
        let line = links.lines[self.part.0 as usize].front().map_or(u64::MAX, |line| line.at);
        line.min(now + self.answer_latency + 1)
    }

    /// Most fetches are hits, and all that becomes of one is known when its ray is the first of the fetch queue, and all before it have left the
    /// ready list: the port is free from cycle `access_at` on, a line is there in the cycle after its access, and the operation begins when those
    /// before it have begun. So accesses are made at once, in their turn, from cycle `from` on, and the ray enters the pipeline, for a
    /// later cycle. All that is before cycle `bound`, in which a line may come from the L2. Whether all accesses were made; if not, the ray goes on
    /// as others do.
    #[inline]
    fn foresee(&mut self, ray: RayId, fetch: &mut Fetch, from: u64, bound: u64) -> bool {
        let access = if fetch.write { Access::Write } else { Access::Read };
        loop {
            let access_at = from.max(self.access_at);
            let begin = (access_at + 1).max(self.open_at);
            if begin >= bound || !self.cache.hit(fetch.line, fetch.class, access) {
                return false;
            }
            self.access_at = access_at + 1;
            fetch.line.0 += 1;
            fetch.left -= 1;
            if fetch.left == 0 {
                self.requested[fetch.class as usize] += Bytes(fetch.bytes.into());
                if fetch.missing == 0 {
                    self.enter_ahead(ray, begin);
                } else {
                    self.waiting += 1;
                }
                return true;
            }
        }
    }

    /// Foresees what becomes of the rays that are queued at the end of cycle `now`, as far as it is known: the ready list, hits that get their
    /// lines in the next cycle, and the fetch queue up to the first line that is not there.
    fn foresee_queued(&mut self, now: u64, links: &mut Links) {
        while let Some(ray) = self.ready.pop_front() {
            self.enter_ahead(ray, self.open_at.max(now + 1));
        }
        let bound = self.first_unknown(now, links);
        if bound <= now + 1 || !self.released.is_empty() {
            return;
        }
        while let Some((_, ray)) = self.hits.pop_front() {
            let fetch = &mut links.rays[ray as usize].fetch;
            fetch.missing -= 1;
            if fetch.missing == 0 && fetch.left == 0 {
                self.waiting -= 1;
                self.enter_ahead(ray, self.open_at.max(now + 1));
            }
        }
        while let Some(&ray) = self.fetching.front().filter(|_| !self.stuck) {
            let fetch = &mut links.rays[ray as usize].fetch;
            if !self.foresee(ray, fetch, now + 1, bound) {
                return;
            }
            self.fetching.drop_front();
        }
    }

    /// An operation of `ray` begins in cycle `at`, which is to come.
    #[inline]
    fn enter_ahead(&mut self, ray: RayId, at: u64) {
        self.enter(ray, at);
        self.causes.begin(at, self.timing.interval);
        self.begins_last = at;
    }

    /// A ray begins to fetch `element` from the L2.
    pub(crate) fn fetch_straight(&mut self, ray: RayId, element: &Element, links: &mut Links) {
        links.rays[ray as usize].fetch = Fetch { straight: true, ..Fetch::of(element, &links.layout) };
        self.fetching.push_back(ray);
    }

    /// A ray is to take an operation that writes `element`, without a fetch.
    pub(crate) fn ready_to_write(&mut self, ray: RayId, element: &Element, links: &mut Links) {
        links.rays[ray as usize].fetch = Fetch::of(element, &links.layout);
        self.ready.push_back(ray);
    }

    /// A ray is to take an operation without a fetch.
    pub(crate) fn ready(&mut self, ray: RayId, links: &mut Links) {
        links.rays[ray as usize].fetch.write = false;
        self.ready.push_back(ray);
    }

    /// Step 5: whether an operation began.
    #[inline]
    pub(crate) fn begin(&mut self, now: u64, rays: &[Ray]) -> bool {
        let began = now >= self.open_at && self.begin_first(now, rays);
        if began {
            self.causes.begin(now, self.timing.interval);
        }
        began
    }

    /// Step 5 of a unit in which several operations can begin at once: whether any did.
    pub(crate) fn begin_several(&mut self, now: u64, rays: &[Ray]) -> bool {
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
        if self.writes != WritePolicy::Back && !self.write_through(&rays[ray as usize].fetch) {
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

    /// Sends the write of an operation down, if it goes through; false if there is no place.
    fn write_through(&mut self, fetch: &Fetch) -> bool {
        if !fetch.write || !self.writes.go_through(fetch.class) {
            return true;
        }
        if self.out.len() == self.out_places {
            return false;
        }
        // An entry of a store lies in one line.
        let bytes = Bytes(fetch.bytes.into());
        self.push_out(fetch.first, fetch.class, true, bytes);
        self.written_through[fetch.class as usize].add(bytes);
        true
    }

    /// Steps 6 and 7, and the account of the cycle: `leaving` says whether a ray waits to go to another unit.
    #[inline]
    pub(crate) fn end(&mut self, now: u64, links: &mut Links, leaving: bool) {
        let lines = links.lines[self.part.0 as usize].front().map_or(u64::MAX, |line| line.at);
        let at = if self.queued() | self.out.len() == 0 && lines > now {
            self.account(now, leaving);
            self.account_ahead(now, leaving);
            self.stages.front().map_or(u64::MAX, |stage| stage.0).min(lines)
        } else {
            self.end_crowded(now, links, leaving, false)
        };
        if at != u64::MAX {
            links.clock.wake(self.part, at);
        }
    }

    /// As [`Pipeline::end`], of a cycle in which the unit took as many rays as it can, others waited, and no operation began.
    pub(crate) fn end_passed_by(&mut self, now: u64, links: &mut Links, leaving: bool) {
        let at = self.end_crowded(now, links, leaving, true);
        if at != u64::MAX {
            links.clock.wake(self.part, at);
        }
    }

    /// As [`Pipeline::end`], where something is queued; returns the next cycle in which something happens that is known.
    fn end_crowded(&mut self, now: u64, links: &mut Links, leaving: bool, passed_by: bool) -> u64 {
        self.accessed = false;
        let stalled = self.access(now, links);
        let sent = !self.out.is_empty() && self.send(now, links);
        let ready = !self.ready.is_empty();
        if passed_by {
            self.causes.passed_by(now, self.idle_cause(leaving || ready));
        } else {
            self.account(now, leaving || ready);
        }
        if self.foresees {
            self.foresee_queued(now, links);
            if ready && !leaving {
                // Where no operation begins from the next cycle on, the next ray waits for a line.
                self.causes.cycle(now + 1, Cause::Memory);
            }
        }
        self.account_ahead(now, leaving || !self.ready.is_empty());

        let lines = links.lines[self.part.0 as usize].front().map_or(u64::MAX, |line| line.at);
        let at_once = !self.released.is_empty()
            || !self.fetching.is_empty() && sent
            || !self.out.is_empty() && sent
            || lines <= now && (self.filled || sent || self.accessed);
        if at_once {
            return now + 1;
        }
        let access = if self.fetching.is_empty() || stalled { u64::MAX } else { self.access_at.max(now + 1) };
        self.next_event(now, lines).min(access)
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
    fn account(&mut self, now: u64, held: bool) {
        let waits_for_line = self.begins_last > now && !held;
        let idle = if waits_for_line { Cause::Memory } else { self.idle_cause(held) };
        self.causes.cycle(now, idle);
    }

    /// Counts the cycles up to that in which the last operation begins that is known to: until then, its ray waits for its line.
    #[inline]
    fn account_ahead(&mut self, now: u64, held: bool) {
        if self.begins_last > now {
            self.causes.ahead(self.begins_last, self.idle_cause(held));
        }
    }

    /// Step 6; whether the queue was stopped.
    #[inline]
    fn access(&mut self, now: u64, links: &mut Links) -> bool {
        if let Some(ray) = self.released.pop_front() {
            self.line_came(ray, &mut links.rays);
            return false;
        }
        if now < self.access_at {
            return false;
        }
        if self.stuck {
            return true;
        }
        self.banks.clear();
        for _ in 0..self.ports {
            let Some(&id) = self.fetching.front() else { return false };
            let ray = &mut links.rays[id as usize];
            let Fetch { line, class, write, straight, .. } = ray.fetch;
            if straight {
                if !self.ask_straight(id, ray) {
                    self.stuck = true;
                    return true;
                }
                continue;
            }
            if !self.banks.take(line, class) {
                return false;
            }
            let access = if write { self.writes.access(class, true) } else { Access::Read };
            let hit = self.cache.hit(line, class, access);
            if !hit && !self.miss(id, ray, access) {
                self.stuck = true;
                return true;
            }
            self.accessed = true;
            let fetch = &mut ray.fetch;
            fetch.line.0 += 1;
            fetch.left -= 1;
            if fetch.left > 0 {
                // With a latency of one cycle, the line is there when the next one is accessed.
                if !hit || self.hit_latency > 1 {
                    self.wait(id, hit, now, fetch);
                }
                continue;
            }
            self.requested[class as usize] += Bytes(fetch.bytes.into());
            self.fetching.drop_front();
            let alone = hit && fetch.missing == 0 && access != Access::WriteThrough;
            if alone && self.is_open_next(now, links.lines[self.part.0 as usize].front()) {
                self.enter_ahead(id, now + 1);
            } else {
                self.waiting += 1;
                self.wait(id, hit, now, fetch);
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

    /// An access of ray `id` to a line that is not there; false if it has to wait.
    fn miss(&mut self, id: RayId, ray: &Ray, access: Access) -> bool {
        let Ray { marked, fetch: Fetch { line, class, .. }, .. } = *ray;
        let room = self.out.len() < self.out_places;
        match self.cache.miss(line, class, access, Some(id), room) {
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

    /// The first ray of the fetch queue, `id`, asks the L2 for its line; false if it has to wait.
    fn ask_straight(&mut self, id: RayId, ray: &mut Ray) -> bool {
        if self.out.len() == self.out_places || self.straight.len() == self.most_straight {
            return false;
        }
        let (marked, fetch) = (ray.marked, &mut ray.fetch);
        let (line, class, bytes) = (fetch.line, fetch.class, Bytes(fetch.bytes.into()));
        (fetch.left, fetch.missing) = (0, 1);
        self.out.push_back(Request { line, class, write: false, bytes, from: self.part, marked });
        self.straight.push_back((line, id));
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
            self.stuck = false;
        }
        sent
    }

    /// A frame begins: lines from `first` on go.
    pub(crate) fn drop_from(&mut self, first: LineAddr) {
        self.cache.drop_from(first);
    }

    /// The L1 holds from now on what `cache` does.
    pub(crate) fn hold(&mut self, cache: &Cache) {
        self.stuck = false;
        self.cache.hold(cache);
    }

    /// Whether nothing is on its way to the L2.
    pub(crate) fn is_idle(&self) -> bool {
        self.out.is_empty() && self.cache.misses_under_way() == 0 && self.straight.is_empty()
    }

    /// The L1.
    pub(crate) fn cache(&self) -> &Cache {
        &self.cache
    }

    /// Bytes that the unit asked its L1 for, by class.
    pub(crate) fn requested(&self) -> &[Bytes; TrafficClass::ALL.len()] {
        &self.requested
    }

    /// Writes that went through, by class.
    pub(crate) fn written_through(&self) -> &[Past; TrafficClass::ALL.len()] {
        &self.written_through
    }

    /// Reads that went past the L1, by class.
    pub(crate) fn read_straight(&self) -> &[Past; TrafficClass::ALL.len()] {
        &self.read_straight
    }

    /// What its L1 alone counted, by class.
    pub(crate) fn l1_counts(&self) -> &[L1Counts; TrafficClass::ALL.len()] {
        self.banks.counts()
    }

    /// Misses of marked rays, by class.
    pub(crate) fn marked(&self) -> &[u64; TrafficClass::ALL.len()] {
        &self.marked
    }

    /// The unit's cycles.
    pub(crate) fn causes(&self) -> &Causes {
        &self.causes
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self) -> String {
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
