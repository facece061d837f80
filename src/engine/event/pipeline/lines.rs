//! Accesses to the L1, and the lines that come for them (steps 1, 2, 6 and 7 of a cycle).

use super::super::links::{Answer, Links, take};
use super::super::ray::{Fetch, Ray, RayId};
use super::unit::Pipeline;
use crate::machine::layout::Element;
use crate::memory::Request;
use crate::memory::cache::{Access, Fill, Lookup, Release};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

impl Pipeline {
    /// Steps 1 and 2 of a cycle: a fill, and hits that get their line.
    #[inline(always)]
    pub(crate) fn arrive(&mut self, now: u64, links: &mut Links) {
        self.filled = false;
        if self.line_at(links) <= now || self.hits.front().is_some_and(|&(at, _)| at <= now) {
            self.arrive_some(now, links);
        }
    }

    fn arrive_some(&mut self, now: u64, links: &mut Links) {
        self.filled = self.line_at(links) <= now && self.fill(now, links);
        self.stuck &= !self.filled;
        while let Some(ray) = take(&mut self.hits, now) {
            self.line_came(ray, &mut links.rays);
        }
    }

    /// The cycle in which the next line can be put in; [`u64::MAX`] if none is known to come.
    #[inline]
    pub(crate) fn line_at(&self, links: &Links) -> u64 {
        links.lines[self.part.0 as usize].front().map_or(u64::MAX, |line| line.at.max(self.fill_at))
    }

    /// Step 1, for a line that is there in cycle `now`. Returns whether it was taken.
    pub(super) fn fill(&mut self, now: u64, links: &mut Links) -> bool {
        let lines = &mut links.lines[self.part.0 as usize];
        let Some(&Answer { line, .. }) = lines.front() else { return false };
        let past = self.bypassing.iter().position(|(asked, _)| *asked == line);
        if let Some(at) = past {
            lines.drop_front();
            self.fill_at = now + 1;
            if let Some((_, ray)) = self.bypassing.remove(at) {
                self.line_came(ray, &mut links.rays);
            }
            return true;
        }
        self.filled_for.clear();
        let room = self.out.len() < self.out_places;
        let Fill::Done { victim } = self.cache.fill(line, room, &mut self.filled_for) else { return false };
        lines.drop_front();
        self.fill_at = now + 1;
        if let Some(victim) = victim {
            self.push_out(victim.line, victim.class, true, self.line, now);
        }
        match self.release {
            Release::Together => {
                for index in 0..self.filled_for.len() {
                    self.line_came(self.filled_for[index], &mut links.rays);
                }
            }
            // The row stays in use until its last ray has left. No access sees this, since none is made until then.
            Release::OneByOne => {
                self.release_at = if self.released.is_empty() { now } else { self.release_at };
                self.released.extend(self.filled_for.drain(..));
                self.access_at = self.access_at.max(self.release_at + self.released.len() as u64);
            }
        }
        true
    }

    #[inline]
    pub(super) fn line_came(&mut self, ray: RayId, rays: &mut [Ray]) {
        let fetch = &mut rays[ray as usize].fetch;
        fetch.missing -= 1;
        if fetch.missing == 0 && fetch.left == 0 {
            self.waiting -= 1;
            self.ready.push_back(ray);
        }
    }

    /// Step 6. Returns whether the fetch queue was stopped.
    #[inline]
    pub(super) fn access(&mut self, now: u64, links: &mut Links) -> bool {
        if self.release_at <= now
            && let Some(ray) = self.released.pop_front()
        {
            self.release_at = now + 1;
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
            let Fetch { line, class, write, bypass, .. } = ray.fetch;
            if bypass {
                if !self.ask_bypass(id, ray, now) {
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
            if !hit && !self.miss(id, ray.attributed, &ray.fetch, access, now) {
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
    pub(super) fn wait(&mut self, ray: RayId, hit: bool, now: u64, fetch: &mut Fetch) {
        fetch.missing += 1;
        if hit {
            self.hits.push_back((now + self.hit_latency, ray));
        }
    }

    /// Whether a ray that makes its last access in this cycle, a hit, begins its operation in the next cycle. It does
    /// if it is the first of the ready list and no other operation can begin beside it. `line` is the first line to
    /// come from the L2. All lines of the next cycle are known, since an answer takes the L2's latency.
    #[inline]
    pub(super) fn is_open_next(&self, now: u64, line: Option<&Answer>) -> bool {
        self.hit_latency == 1
            && self.timing.width == 1
            && self.open_at <= now + 1
            && self.ready.is_empty()
            && self.hits.is_empty()
            && line.is_none_or(|line| line.at > now + 1)
    }

    /// Handles an access of ray `id` to an absent line in cycle `at`; `attributed` says whether the miss counts among
    /// the attributed ones. Returns false if the access has to wait.
    pub(super) fn miss(&mut self, id: RayId, attributed: bool, fetch: &Fetch, access: Access, at: u64) -> bool {
        let Fetch { line, class, .. } = *fetch;
        let room = self.out.len() < self.out_places;
        match self.cache.miss(line, class, access, Some(id), room) {
            Lookup::Stalled => return false,
            Lookup::Hit | Lookup::WriteAround => unreachable!("the line is not there, and a ray waits for the data"),
            Lookup::Merged => {}
            Lookup::Miss => {
                self.attributed[class as usize] += u64::from(attributed);
                let bytes = self.line;
                self.out.push_back((at, Request { line, class, write: false, bytes, from: self.part, attributed }));
            }
        }
        true
    }

    /// The first ray of the fetch queue, `id`, requests its line from the L2. Returns false if it has to wait.
    pub(super) fn ask_bypass(&mut self, id: RayId, ray: &mut Ray, now: u64) -> bool {
        if self.out.len() == self.out_places || self.bypassing.len() == self.most_bypassing {
            return false;
        }
        let (attributed, fetch) = (ray.attributed, &mut ray.fetch);
        let (line, class, bytes) = (fetch.line, fetch.class, Bytes(fetch.bytes.into()));
        (fetch.line.0, fetch.left, fetch.missing) = (line.0 + 1, 0, 1);
        self.out.push_back((now, Request { line, class, write: false, bytes, from: self.part, attributed }));
        self.bypassing.push_back((line, id));
        self.bypassed[class as usize].add(bytes);
        self.waiting += 1;
        self.fetching.drop_front();
        true
    }

    pub(super) fn push_out(&mut self, line: LineAddr, class: TrafficClass, write: bool, bytes: Bytes, now: u64) {
        self.out.push_back((now, Request { line, class, write, bytes, from: self.part, attributed: false }));
    }

    /// Step 7. Returns whether the first request of the out queue found a place.
    pub(super) fn send(&mut self, now: u64, links: &mut Links) -> bool {
        let request = self.out.front().filter(|(at, _)| *at <= now);
        let sent = request.is_some_and(|&(_, request)| links.l2.put(self.core, request, now, &mut links.clock));
        if sent {
            self.out.drop_front();
            self.stuck = false;
        }
        sent
    }

    /// Step 7 of a unit that has worked ahead. Returns the cycle in which the next request can be sent; [`u64::MAX`]
    /// if it is not known.
    pub(crate) fn send_due(&mut self, now: u64, links: &mut Links) -> u64 {
        let waits = self.out.front().is_some_and(|&(at, _)| at <= now) && !self.send(now, links);
        if waits { u64::MAX } else { self.sends_at().max(now + 1) }
    }

    /// The cycle in which the first waiting request is made; [`u64::MAX`] if there is none.
    #[inline]
    pub(crate) fn sends_at(&self) -> u64 {
        self.out.front().map_or(u64::MAX, |&(at, _)| at)
    }

    /// A ray begins to fetch `element` from the L2, past the L1.
    pub(crate) fn fetch_bypass(&mut self, ray: RayId, element: &Element, links: &mut Links) {
        links.rays[ray as usize].fetch = Fetch { bypass: true, ..Fetch::of(element, &links.layout) };
        self.fetching.push_back(ray);
    }
}
