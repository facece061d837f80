//! The beginning and end of operations (steps 3 and 5 of a cycle), and the cause of the cycle.

use super::super::links::{Links, take};
use super::super::ray::{Fetch, Ray, RayId};
use super::unit::Pipeline;
use crate::machine::layout::Element;
use crate::machine::writes::WritePolicy;
use crate::quantity::Bytes;
use crate::stats::Cause;

impl Pipeline {
    /// Step 3. Returns the ray whose operation ends.
    #[inline]
    pub(crate) fn leave(&mut self, now: u64) -> Option<RayId> {
        take(&mut self.stages, now)
    }

    /// Drops the first operation, which has ended.
    #[inline]
    pub(crate) fn drop_first(&mut self) {
        self.stages.drop_front();
    }

    /// Drops the first operation if it ended before cycle `now`. Returns whether it did.
    #[inline]
    pub(crate) fn left_before(&mut self, now: u64) -> bool {
        let left = self.ends_at() < now;
        if left {
            self.stages.drop_front();
        }
        left
    }

    /// Operation `index` in the pipeline: its end cycle, and its ray.
    #[inline]
    pub(crate) fn operation(&mut self, index: usize) -> Option<&mut (u64, RayId)> {
        self.stages.get_mut(index)
    }

    /// The end cycle of the first operation; [`u64::MAX`] if there is none.
    #[inline]
    pub(crate) fn ends_at(&self) -> u64 {
        self.stages.front().map_or(u64::MAX, |stage| stage.0)
    }

    /// The end cycle of the last operation; [`u64::MAX`] if there is none.
    #[inline]
    pub(crate) fn drains_at(&self) -> u64 {
        self.stages.back().map_or(u64::MAX, |stage| stage.0)
    }

    /// Makes a ray ready for an operation that writes `element`, without a fetch.
    pub(crate) fn ready_to_write(&mut self, ray: RayId, element: &Element, links: &mut Links) {
        links.rays[ray as usize].fetch = Fetch::of(element, &links.layout);
        self.ready.push_back(ray);
    }

    /// Makes a ray ready for an operation without a fetch.
    pub(crate) fn ready(&mut self, ray: RayId, links: &mut Links) {
        links.rays[ray as usize].fetch.write = false;
        self.ready.push_back(ray);
    }

    /// Step 5. Returns whether an operation began.
    #[inline]
    pub(crate) fn begin(&mut self, now: u64, rays: &[Ray]) -> bool {
        let began = now >= self.open_at && self.begin_first(now, rays);
        if began {
            self.causes.begin(now, self.timing.interval);
        }
        began
    }

    /// Step 5 of a unit in which several operations can begin in a cycle. Returns whether any did.
    pub(crate) fn begin_several(&mut self, now: u64, rays: &[Ray]) -> bool {
        let began = self.begin(now, rays);
        if began {
            self.beside += (1..self.timing.width).take_while(|_| self.begin_first(now, rays)).count() as u64;
        }
        began
    }

    /// Operations that began in a run of `cycles`.
    pub(crate) fn operations(&self, cycles: u64) -> u64 {
        self.causes.until(cycles)[Cause::Busy as usize].div_ceil(self.timing.interval) + self.beside
    }

    /// The first ray of the ready list begins its operation, if nothing is missing.
    #[inline]
    pub(super) fn begin_first(&mut self, now: u64, rays: &[Ray]) -> bool {
        let Some(&ray) = self.ready.front() else { return false };
        if self.writes != WritePolicy::Back && !self.write_through(&rays[ray as usize].fetch, now) {
            return false;
        }
        self.ready.drop_front();
        self.enter(ray, now);
        true
    }

    /// An operation of `ray` begins in cycle `at`.
    #[inline]
    pub(super) fn enter(&mut self, ray: RayId, at: u64) {
        self.stages.push_back((at + self.timing.latency, ray));
        self.open_at = at + self.timing.interval;
    }

    /// Sends the write of an operation that begins to the L2, if it is written through. Returns false if there is no
    /// place.
    pub(super) fn write_through(&mut self, fetch: &Fetch, now: u64) -> bool {
        if !fetch.write || !self.writes.go_through(fetch.class) {
            return true;
        }
        if self.out.len() == self.out_places {
            return false;
        }
        // An entry of a store lies in one line.
        let bytes = Bytes(fetch.bytes.into());
        self.push_out(fetch.only_line(), fetch.class, true, bytes, now);
        self.written_through[fetch.class as usize].add(bytes);
        true
    }

    /// Steps 6 and 7, and the account of the cycle; `leaving` says whether a ray waits to go to another unit. Returns
    /// the next cycle of a known event other than the end of an operation; [`u64::MAX`] if none is known.
    #[inline(always)]
    pub(crate) fn end(&mut self, now: u64, links: &mut Links, leaving: bool) -> u64 {
        let lines = self.line_at(links);
        if self.queued() | self.out.len() == 0 && lines > now {
            self.account(now, leaving);
            self.account_ahead(now, leaving);
            lines
        } else {
            self.end_crowded(now, links, leaving, false)
        }
    }

    /// [`Pipeline::end`] where something is queued. `passed_by` says that the unit took as many rays in this cycle as
    /// it can, others waited, and no operation began.
    pub(crate) fn end_crowded(&mut self, now: u64, links: &mut Links, leaving: bool, passed_by: bool) -> u64 {
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
                // If no operation begins from the next cycle on, the next ray waits for a line.
                self.causes.cycle(now + 1, Cause::Memory);
            }
        }
        self.account_ahead(now, leaving || !self.ready.is_empty());

        let lines = self.line_at(links);
        let at_once = !self.released.is_empty()
            || !self.fetching.is_empty() && sent
            || !self.out.is_empty() && sent
            || lines <= now && (self.filled || sent || self.accessed);
        if at_once {
            return now + 1;
        }
        let access = if self.fetching.is_empty() || stalled { u64::MAX } else { self.access_at.max(now + 1) };
        // The unit is woken when there is a place for a request that has waited since this cycle or longer.
        let sends = if self.sends_at() > now { self.sends_at() } else { u64::MAX };
        self.next_event(now, lines).min(access).min(sends)
    }

    /// The next cycle in which an operation may begin or a line arrive; [`u64::MAX`] if none is known. `lines` is the
    /// cycle of the first line.
    #[inline]
    pub(super) fn next_event(&self, now: u64, lines: u64) -> u64 {
        let begin = if self.ready.is_empty() { u64::MAX } else { self.open_at.max(now + 1) };
        let line = if lines > now { lines } else { u64::MAX };
        let hit = self.hits.front().map_or(u64::MAX, |hit| hit.0);
        begin.min(line).min(hit)
    }

    /// The cause of cycles in which nothing happens; `held` says whether a ray waits for a place in the pipeline or
    /// elsewhere.
    #[inline]
    pub(super) fn idle_cause(&self, held: bool) -> Cause {
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
    pub(super) fn account(&mut self, now: u64, held: bool) {
        let waits_for_line = self.begins_last > now && !held;
        let idle = if waits_for_line { Cause::Memory } else { self.idle_cause(held) };
        self.causes.cycle(now, idle);
    }

    /// Counts the cycles until the last known operation begins: its ray waits for its line until then.
    #[inline]
    pub(super) fn account_ahead(&mut self, now: u64, held: bool) {
        if self.begins_last > now {
            self.causes.ahead(self.begins_last, self.idle_cause(held));
        }
    }
}
