//! The traversal unit: fetches nodes and tests their boxes.

use super::links::{Back, Links, take};
use super::memory::Memory;
use super::pipeline::{Pipeline, Stages};
use super::ray::RayId;
use crate::machine::parts::Parts;
use crate::machine::traversal::TraversalSpec;
use crate::machine::writes::WritePolicy;
use crate::memory::Wake;
use crate::memory::ring::Ring;
use crate::stream::Step;

/// A traversal unit.
#[derive(Clone, Debug)]
pub(crate) struct Traversal {
    index: u32,
    /// The common part.
    pub pipeline: Pipeline,
    /// Rays that wait to go to a list or intersection unit.
    leaving: Ring<RayId>,
    /// Rays that are done and wait for the out FIFO.
    done: Ring<RayId>,
    /// All work before this cycle that concerns the unit alone is done.
    worked_to: u64,
}

/// The first ray to arrive at a unit.
#[derive(Clone, Copy, Debug)]
struct Coming {
    /// The cycle in which it arrives; [`u64::MAX`] if none is known to come.
    at: u64,
    ray: RayId,
    /// Whether it returns from another unit; if not, it comes from the dispatcher.
    returns: bool,
}

impl Coming {
    /// The first ray to arrive at unit `index`. In the same cycle, rays that return come first.
    #[inline]
    fn first(links: &Links, index: usize) -> Self {
        let (at, ray) = links.dispatched[index].front().copied().unwrap_or((u64::MAX, 0));
        match links.returned[index].front() {
            Some(&Back { at: back, ray, .. }) if back <= at => Self { at: back, ray, returns: true },
            _ => Self { at, ray, returns: false },
        }
    }

    /// Removes it from its queue at unit `index`.
    #[inline]
    fn take(self, links: &mut Links, index: usize) {
        if self.returns {
            links.returned[index].drop_front();
        } else {
            links.dispatched[index].drop_front();
        }
    }
}

impl Traversal {
    /// Unit `index`, empty.
    pub(crate) fn new(spec: &TraversalSpec, memory: Memory, index: u32, links: &Links) -> Self {
        let part = links.parts.traversal(index);
        let stages = Stages { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        let core = links.parts.core(part);
        let pipeline = Pipeline::new(part, core, &spec.cache, stages, WritePolicy::Back, memory);
        Self { index, pipeline, leaving: Ring::new(), done: Ring::new(), worked_to: 0 }
    }

    /// Acts in cycle `now`.
    pub(crate) fn tick(&mut self, now: u64, links: &mut Links) {
        let (part, index) = (self.pipeline.part(), self.index as usize);
        if now < self.worked_to {
            let sends = self.pipeline.send_due(now, links);
            return links.clock.wake_if(part, sends.min(links.wakes[index]));
        }
        self.pipeline.arrive(now, links);
        if let Some(id) = self.pipeline.leave(now) {
            let ray = &mut links.rays[id as usize];
            ray.steps.advance();
            links.replayed.count_visit(ray.kind);
            self.route(id, now, links);
        }
        while let Some(&Back { ray, .. }) = links.returned[index].front().filter(|back| back.at <= now) {
            links.returned[index].drop_front();
            self.route(ray, now, links);
        }
        while let Some(ray) = take(&mut links.dispatched[index], now) {
            self.route(ray, now, links);
        }
        while self.done.front().is_some_and(|&id| links.send_out(id, part, now)) {
            self.done.drop_front();
            links.freed.push(self.index);
        }
        self.pipeline.begin(now, &links.rays);
        let sent = !self.leaving.is_empty() && self.send(now, links);
        let leaving = !self.leaving.is_empty() || !self.done.is_empty();
        let next = self.pipeline.end(now, links, leaving);
        let next = if !leaving && self.pipeline.can_work_ahead() {
            let next = self.work_ahead(now, links);
            self.worked_to = next.min(links.reach(now));
            links.clock.wake_if(part, self.pipeline.sends_at().max(now + 1));
            next
        } else if sent && leaving {
            now + 1
        } else {
            next.min(self.pipeline.ends_at()).min(Coming::first(links, index).at)
        };
        links.wakes[index] = next;
        links.clock.wake_if(part, next);
    }

    /// Does the work after cycle `now` that concerns the unit alone: lines arrive, rays return and fetch nodes, and
    /// their operations begin and end. Returns the first cycle in which something else happens, or in which something
    /// unknown may arrive; [`u64::MAX`] if nothing is known.
    fn work_ahead(&mut self, now: u64, links: &mut Links) -> u64 {
        let index = self.index as usize;
        let end = links.reach(now);
        let mut line = self.pipeline.line_at(links).min(end);
        if !self.pipeline.go_on(now + 1, line, links) {
            return now + 1;
        }
        let mut bound = self.pipeline.bound(line);
        let mut coming = Coming::first(links, index);
        loop {
            let (ends, leaving) = self.pipeline.next_to_leave();
            let at = ends.min(coming.at);
            if at >= bound {
                line = match self.pipeline.take_line_ahead(line, end, links) {
                    Ok(line) => line,
                    // If nothing is known ahead, an access that is possible by now is made in the next cycle.
                    Err(next) => return next.min(at).max(now + 1),
                };
                bound = self.pipeline.bound(line);
                continue;
            }
            let passed = ends == at;
            let id = if passed { leaving } else { coming.ray };
            let ray = &mut links.rays[id as usize];
            let node = if passed { ray.steps.node_behind() } else { ray.steps.node() };
            let Some(node) = node else { return at };
            if passed {
                ray.steps.advance();
                links.replayed.count_visit(ray.kind);
                self.pipeline.drop_first();
            } else {
                coming.take(links, index);
                coming = Coming::first(links, index);
            }
            let fetch = links.node_fetch(node);
            if !self.pipeline.fetch_ahead(id, fetch, at, (line, bound), links) {
                return at;
            }
        }
    }

    /// Sends the first leaving ray to a list or an intersection unit. Returns whether it found a place.
    fn send(&mut self, now: u64, links: &mut Links) -> bool {
        let (core, part) = (self.pipeline.core(), self.pipeline.part());
        let sent = self.leaving.front().is_some_and(|&id| match links.rays[id as usize].path_step() {
            Some(Step::List(_)) => links.send_to_list(id, core, part, now),
            _ => links.send_to_test(id, core, part, now),
        });
        if sent {
            self.leaving.drop_front();
        }
        sent
    }

    #[inline]
    fn route(&mut self, id: RayId, now: u64, links: &mut Links) {
        match links.rays[id as usize].path_step() {
            Some(Step::Node(node)) => {
                let element = links.layout.node(node);
                self.pipeline.fetch(id, &element, now, links);
            }
            Some(_) => self.leaving.push_back(id),
            None => self.retire(id, now, links),
        }
    }

    /// The path of a ray is done.
    fn retire(&mut self, id: RayId, now: u64, links: &mut Links) {
        links.retire(id);
        if links.rays[id as usize].steps.has_policy() {
            links.freed.push(self.index);
            links.send_to_shadow_cache(id, now);
            links.clock.wake(Parts::DISPATCHER, now + 1);
        } else {
            self.done.push_back(id);
        }
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self) -> String {
        format!("{}, leaving for lists or intersection {}", self.pipeline.queues(), self.leaving.len())
    }
}
