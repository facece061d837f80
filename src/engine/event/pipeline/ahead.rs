//! Work ahead of the other parts' time (lookahead), for a unit that only reads: lines arrive, accesses are made and
//! operations begin in cycles to come.

use super::super::links::Links;
use super::super::ray::{Fetch, RayId};
use super::unit::Pipeline;
use crate::memory::cache::{Access, Release};
use crate::quantity::Bytes;
use crate::stats::Cause;

impl Pipeline {
    /// Whether only lines and rays that arrive can change the unit's state.
    #[inline]
    pub(crate) fn can_work_ahead(&self) -> bool {
        // A ray that is stuck for lack of a place in the out queue goes on as soon as the L2 has a place.
        let waits_for_place = self.stuck && self.out.len() == self.out_places;
        self.foresees && self.ready.is_empty() && self.bypassing.is_empty() && !waits_for_place
    }

    /// The end cycle of the first operation, and its ray; [`u64::MAX`] if there is none.
    #[inline]
    pub(crate) fn next_to_leave(&self) -> (u64, RayId) {
        self.stages.front().copied().unwrap_or((u64::MAX, 0))
    }

    /// The cycle before which a hit that gets its data precedes every ray not entered yet, if no line can be put in
    /// before cycle `line`.
    #[inline]
    pub(crate) fn bound(&self, line: u64) -> u64 {
        line.min(self.releases_at().saturating_add(1))
    }

    /// The cycle in which a line is next given to one of the rays that get it one by one; [`u64::MAX`] if no ray waits
    /// for this.
    #[inline]
    fn releases_at(&self) -> u64 {
        if self.released.is_empty() { u64::MAX } else { self.release_at }
    }

    /// The first cycle in which a waiting access can be made or a hit gets its data; [`u64::MAX`] if there is none.
    #[inline]
    fn pending_at(&self) -> u64 {
        let access = if self.fetching.is_empty() || self.stuck { u64::MAX } else { self.access_at };
        self.hits.front().map_or(access, |hit| hit.0.min(access))
    }

    /// Begins a fetch of a ray in cycle `at`. No line can be put in before cycle `line`; `bound` is the result of
    /// [`Pipeline::bound`]. Returns whether this was possible; if not, the unit must act in its next cycle.
    #[inline]
    pub(crate) fn fetch_ahead(
        &mut self,
        ray: RayId,
        mut fetch: Fetch,
        at: u64,
        (line, bound): (u64, u64),
        links: &mut Links,
    ) -> bool {
        // The fast path: most lines are present, and most units are busy.
        let mut there_at = 0;
        if self.fetching.is_empty() && !self.stuck {
            while fetch.left > 0 {
                let access_at = self.access_at.max(at);
                there_at = access_at + self.hit_latency;
                if there_at >= bound || !self.cache.hit(fetch.line, fetch.class, Access::Read) {
                    break;
                }
                self.access_at = access_at + 1;
                fetch.line.0 += 1;
                fetch.left -= 1;
            }
        }
        if fetch.left > 0 {
            return self.fetch_slowly_ahead(ray, fetch, at, line, links);
        }
        self.requested[fetch.class as usize] += Bytes(fetch.bytes.into());
        self.enter_ahead(ray, there_at.max(self.open_at));
        if !self.causes.is_busy_from(at) {
            self.account(at, false);
        }
        self.account_ahead(at, false);
        true
    }

    /// [`Pipeline::fetch_ahead`] for a fetch that may have begun, and for any state of the unit.
    fn fetch_slowly_ahead(&mut self, ray: RayId, mut fetch: Fetch, at: u64, line: u64, links: &mut Links) -> bool {
        let mut done = true;
        if self.fetching.is_empty() && !self.stuck {
            let attributed = links.rays[ray as usize].attributed;
            while done && fetch.left > 0 && self.access_at.max(at) < line {
                done = self.access_ahead(ray, attributed, &mut fetch, at, line);
            }
        }
        if fetch.left > 0 {
            self.fetching.push_back(ray);
        }
        if fetch.left > 0 || fetch.missing > 0 {
            links.rays[ray as usize].fetch = fetch;
        }
        if self.begins_last <= at || !self.causes.is_busy_from(at) {
            self.account(at, false);
        }
        self.account_ahead(at, false);
        done || self.stuck
    }

    /// Makes the next access of a ray's fetch, in cycle `from` or later. Returns whether this was possible.
    #[inline]
    fn access_ahead(&mut self, ray: RayId, attributed: bool, fetch: &mut Fetch, from: u64, line: u64) -> bool {
        let at = self.access_at.max(from);
        let hit = self.cache.hit(fetch.line, fetch.class, Access::Read);
        if !hit && !self.miss(ray, attributed, fetch, Access::Read, at) {
            self.stuck = self.out.len() < self.out_places;
            return false;
        }
        let there_at = at + self.hit_latency;
        let waits = hit && there_at >= self.bound(line);
        if waits {
            self.hits.push_back((there_at, ray));
        }
        self.access_at = at + 1;
        fetch.line.0 += 1;
        fetch.left -= 1;
        fetch.missing += u8::from(!hit | waits);
        if fetch.left == 0 {
            self.requested[fetch.class as usize] += Bytes(fetch.bytes.into());
            if fetch.missing == 0 {
                self.enter_ahead(ray, there_at.max(self.open_at));
            } else {
                self.waiting += 1;
            }
        }
        true
    }

    /// Goes on with hits and with accesses of the fetch queue, from cycle `from` on. No line can be put in before
    /// cycle `line`. Returns whether this was possible; if not, the unit must act in its next cycle.
    pub(crate) fn go_on(&mut self, from: u64, line: u64, links: &mut Links) -> bool {
        let bound = self.bound(line);
        while let Some(&(at, ray)) = self.hits.front().filter(|hit| hit.0 < bound) {
            self.hits.drop_front();
            self.enter_if_there(ray, at, links);
        }
        let mut done = true;
        while let Some(&ray) = self.fetching.front()
            && done
            && !self.stuck
            && self.access_at.max(from) < line
        {
            let state = &mut links.rays[ray as usize];
            done = self.access_ahead(ray, state.attributed, &mut state.fetch, from, line);
            if done && state.fetch.left == 0 {
                self.fetching.drop_front();
            }
        }
        self.account_ahead(from, false);
        done || self.stuck
    }

    /// Handles the next event of a line before cycle `end`: puts in the line due in cycle `line`, or gives a line that
    /// was put in to the next ray waiting for it. Returns the cycle of the next line, at most `end`; as an error, the
    /// first cycle in which the unit must act by itself.
    pub(crate) fn take_line_ahead(&mut self, line: u64, end: u64, links: &mut Links) -> Result<u64, u64> {
        let releases = self.releases_at();
        if line < end && line <= releases {
            if !self.fill_ahead(line, links) {
                return Err(line);
            }
            let next = self.line_at(links).min(end);
            if self.go_on(line, next, links) { Ok(next) } else { Err(line) }
        } else if releases < end {
            self.release_ahead(releases, links);
            if self.go_on(releases, line, links) { Ok(line) } else { Err(releases) }
        } else {
            Err(releases.min(self.line_at(links)).min(self.pending_at()))
        }
    }

    /// Puts in the line that arrives in cycle `at`. Returns whether this was possible.
    fn fill_ahead(&mut self, at: u64, links: &mut Links) -> bool {
        if !self.fill(at, links) {
            return false;
        }
        self.stuck = false;
        while let Some(ray) = self.ready.pop_front() {
            self.enter_ahead(ray, self.open_at.max(at));
        }
        if self.release == Release::Together {
            self.account(at, false);
        }
        true
    }

    /// In cycle `at`, gives a line to the next of the rays that get it one by one.
    fn release_ahead(&mut self, at: u64, links: &mut Links) {
        if let Some(ray) = self.released.pop_front() {
            self.release_at = at + 1;
            if self.enter_if_there(ray, at + 1, links) {
                // The ray is ready at the end of the cycle. If no operation begins after it, the next ray waits for a
                // line.
                self.causes.cycle(at, Cause::Blocked);
                self.causes.cycle(at + 1, Cause::Memory);
            }
        }
    }

    /// Gives a ray a line; if it has all its lines, its operation begins in cycle `at` or later. Returns whether it
    /// has all.
    #[inline]
    fn enter_if_there(&mut self, ray: RayId, at: u64, links: &mut Links) -> bool {
        let fetch = &mut links.rays[ray as usize].fetch;
        fetch.missing -= 1;
        let there = fetch.missing == 0 && fetch.left == 0;
        if there {
            self.waiting -= 1;
            self.enter_ahead(ray, self.open_at.max(at));
        }
        there
    }
}
