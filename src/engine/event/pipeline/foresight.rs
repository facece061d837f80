//! Hits are foreseen: most fetches are hits, and all that becomes of one is known when its ray is the first of the
//! fetch queue.

use super::super::links::Links;
use super::super::ray::{Fetch, RayId};
use super::unit::Pipeline;
use crate::machine::layout::Element;
use crate::memory::cache::Access;
use crate::quantity::Bytes;

impl Pipeline {
    /// Hits are not foreseen: for a unit in which rays get ready without a fetch.
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
    pub(super) fn queued(&self) -> usize {
        self.fetching.len() | self.hits.len() | self.ready.len() | self.released.len()
    }

    /// The first cycle in which a line may come from the L2: those on their way are known, others take the L2's
    /// latency. At the latest, that in which a hit is there whose access is made after the next look: what is made
    /// ahead of a look is counted in it.
    #[inline]
    pub(super) fn first_unknown(&self, now: u64, links: &Links) -> u64 {
        let after_look = links.looked_at.saturating_add(self.hit_latency + 1);
        self.line_at(links).min(now + self.answer_latency + 1).min(after_look)
    }

    /// Most fetches are hits, and all that becomes of one is known when its ray is the first of the fetch queue, and
    /// all before it have left the ready list: the port is free from cycle `access_at` on, a line is there a hit's
    /// latency after its access, and the operation begins when those before it have begun. So accesses are made at
    /// once, in their turn, from cycle `from` on, and the ray enters the pipeline, for a later cycle. All that is
    /// before cycle `bound`, in which a line may come from the L2. Whether all accesses were made; if not, the ray goes
    /// on as others do.
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

    /// Foresees what becomes of the rays that are queued at the end of cycle `now`, as far as it is known: the ready
    /// list, hits that get their lines, and the fetch queue up to the first line that is not there.
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

    /// An operation of `ray` begins in cycle `at`, which is to come.
    #[inline(always)]
    pub(super) fn enter_ahead(&mut self, ray: RayId, at: u64) {
        self.enter(ray, at);
        self.causes.begin(at, self.timing.interval);
        self.begins_last = at;
    }
}
