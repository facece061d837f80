//! Foresees hits: most fetches are hits, and the whole course of a hit is known when its ray is the first of the fetch
//! queue.

use super::super::links::Links;
use super::super::ray::{Fetch, RayId};
use super::unit::Pipeline;
use crate::machine::layout::Element;
use crate::memory::cache::Access;
use crate::quantity::Bytes;

impl Pipeline {
    /// Turns foresight off, for a unit in which rays become ready without a fetch.
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

    /// Zero if no access and no operation waits in any queue or list.
    #[inline]
    pub(super) fn queued(&self) -> usize {
        self.fetching.len() | self.hits.len() | self.ready.len() | self.released.len()
    }

    /// The first cycle in which a line may come from the L2: lines on their way are known, others take the L2's
    /// latency. An observed cycle limits it to the cycle in which the first hit accessed after it arrives, because an
    /// access made ahead of an observed cycle would be counted in it.
    #[inline]
    pub(super) fn first_unknown(&self, now: u64, links: &Links) -> u64 {
        let after_look = links.looked_at.saturating_add(self.hit_latency + 1);
        self.line_at(links).min(now + self.answer_latency + 1).min(after_look)
    }

    /// Makes all accesses of a fetch at once, for cycles from `from` on, and enters the ray into the pipeline for a
    /// later cycle. The ray must be the first of the fetch queue, and all rays before it must have left the ready
    /// list.
    ///
    /// The course of a hit is then known. The port is free from cycle `access_at` on, a line arrives a hit's latency
    /// after its access, and the operation begins after those before it. Foresight ends at a miss and at cycle
    /// `bound`, in which a line may come from the L2. Returns whether all accesses were made; if not, the ray goes on
    /// as others do.
    #[inline]
    pub(super) fn foresee(&mut self, ray: RayId, fetch: &mut Fetch, from: u64, bound: u64) -> bool {
        let access = if fetch.write { Access::Write } else { Access::Read };
        loop {
            let access_at = from.max(self.access_at);
            let there_at = access_at + self.hit_latency;
            let begin = there_at.max(self.open_at);
            if there_at >= bound || !self.cache.hit(fetch.line, fetch.class, access) {
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

    /// Foresees the course of rays that are queued at the end of cycle `now`, as far as it is known: the ready list,
    /// hits that get their lines, and the fetch queue up to the first absent line.
    pub(super) fn foresee_queued(&mut self, now: u64, links: &mut Links) {
        while let Some(ray) = self.ready.pop_front() {
            self.enter_ahead(ray, self.open_at.max(now + 1));
        }
        let bound = self.first_unknown(now, links);
        if bound <= now + 1 || !self.released.is_empty() {
            return;
        }
        while let Some(&(at, ray)) = self.hits.front() {
            if at >= bound {
                return;
            }
            self.hits.drop_front();
            let fetch = &mut links.rays[ray as usize].fetch;
            fetch.missing -= 1;
            if fetch.missing == 0 && fetch.left == 0 {
                self.waiting -= 1;
                self.enter_ahead(ray, self.open_at.max(at));
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

    /// Lets an operation of `ray` begin in cycle `at`, which is to come.
    #[inline(always)]
    pub(super) fn enter_ahead(&mut self, ray: RayId, at: u64) {
        self.enter(ray, at);
        self.causes.begin(at, self.timing.interval);
        self.begins_last = at;
    }
}
