//! The intersection unit: fetches triangle records in two phases and tests them.

use super::links::Links;
use super::memory::Memory;
use super::pipeline::{Pipeline, Stages};
use super::ray::{FREES_LIST, GONE, RayId};
use crate::machine::intersection::IntersectionSpec;
use crate::machine::writes::WritePolicy;
use crate::memory::ring::Ring;
use crate::stream::{Step, Stop};

/// An intersection unit.
#[derive(Clone, Debug)]
pub(crate) struct Intersection {
    index: usize,
    /// The common part.
    pub pipeline: Pipeline,
    /// Rays that wait to go to a division unit.
    leaving: Ring<RayId>,
    contexts: usize,
    free: usize,
    /// Number of operations, from the pipeline's front on, that [`Intersection::send_back`] has handled.
    known: usize,
    /// End cycles of handled operations at whose end the unit must act: the ray goes on, or frees a list context.
    heard: Ring<u64>,
}

impl Intersection {
    /// Unit `index`, empty; `writes` is the policy for writes to entries of stores, if they come this way.
    pub(crate) fn new(spec: &IntersectionSpec, writes: WritePolicy, memory: Memory, index: u32, links: &Links) -> Self {
        let part = links.parts.intersection(index);
        let stages = Stages { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        Self {
            index: index as usize,
            pipeline: Pipeline::new(part, links.parts.core(part), &spec.cache, stages, writes, memory),
            leaving: Ring::new(),
            contexts: spec.tests.size(),
            free: spec.tests.size(),
            known: 0,
            heard: Ring::new(),
        }
    }

    /// Acts in cycle `now`.
    pub(crate) fn tick(&mut self, now: u64, links: &mut Links) {
        self.free += std::mem::take(&mut links.freed_tests[self.index]);
        while self.pipeline.left_before(now) {
            self.known -= 1;
            self.free += 1;
        }
        let free_at_start = self.free > 0;
        self.pipeline.arrive(now, links);
        if let Some(id) = self.pipeline.leave(now) {
            self.leave(id, now, links);
        }
        if free_at_start && let Some(id) = links.tests[self.index].take(now, &mut links.clock) {
            self.free -= 1;
            self.take_on(id, now, links);
        }
        self.pipeline.begin(now, &links.rays);
        let (core, part) = (self.pipeline.core(), self.pipeline.part());
        let sent = self.leaving.front().is_some_and(|&id| links.send_to_division(id, core, part, now));
        if sent {
            self.leaving.pop_front();
        }
        let mut next = self.pipeline.end(now, links, !self.leaving.is_empty());
        self.send_back(links);
        if sent && !self.leaving.is_empty() {
            next = now + 1;
        }
        // The cause of idle cycles changes when the last operation ends.
        let ends = self.heard.front().copied().unwrap_or_else(|| self.pipeline.drains_at());
        if let Some(at) = links.tests[self.index].next_at() {
            let free_at = if self.free > 0 { now + 1 } else { self.pipeline.ends_at().saturating_add(1) };
            next = next.min(at.max(free_at));
        }
        links.clock.wake_if(part, next.min(ends));
    }

    fn take_on(&mut self, id: RayId, now: u64, links: &mut Links) {
        let ray = &mut links.rays[id as usize];
        ray.at_edges = false;
        let element = match ray.step() {
            Some(Step::Triangle { slot, .. }) => links.layout.plane(slot),
            Some(step) if step.entry().is_some() => links.entry_element(id),
            step => unreachable!("{step:?} is not for an intersection unit"),
        };
        self.pipeline.fetch(id, &element, now, links);
    }

    /// A ray leaves the pipeline: one that was sent back ahead of time, or one whose operation has ended.
    fn leave(&mut self, id: RayId, now: u64, links: &mut Links) {
        self.known -= 1;
        if id & (GONE | FREES_LIST) != GONE {
            self.heard.drop_front();
        }
        if id & GONE == 0 {
            return self.passed(id, now, links);
        }
        self.free += 1;
        links.left(id, self.pipeline.core(), now);
    }

    /// Sends back rays whose test ends with the operation that they have begun.
    fn send_back(&mut self, links: &mut Links) {
        let part = self.pipeline.part();
        while let Some((ends, id)) = self.pipeline.operation(self.known) {
            let ray = &links.rays[*id as usize];
            if let Some(Step::Triangle { stop, .. }) = ray.step()
                && (stop == Stop::Plane || ray.at_edges && !ray.is_divided(stop))
            {
                *id = links.tested_ahead(*id, part, *ends);
            }
            if *id & (GONE | FREES_LIST) != GONE {
                self.heard.push_back(*ends);
            }
            self.known += 1;
        }
    }

    /// An operation of the ray has ended.
    fn passed(&mut self, id: RayId, now: u64, links: &mut Links) {
        let ray = &mut links.rays[id as usize];
        let Some(Step::Triangle { slot, stop }) = ray.step() else { return self.give_back(id, now, links) };
        if stop != Stop::Plane && !ray.at_edges {
            ray.at_edges = true;
            let element = links.layout.edges(slot);
            self.pipeline.fetch(id, &element, now, links);
        } else if ray.is_divided(stop) {
            self.leaving.push_back(id);
        } else {
            self.give_back(id, now, links);
        }
    }

    fn give_back(&mut self, id: RayId, now: u64, links: &mut Links) {
        self.free += 1;
        links.tested(id, now);
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self, links: &Links) -> String {
        let queue = &links.tests[self.index];
        format!(
            "{}, queue {}/{}, tests {}/{}, leaving for division {}",
            self.pipeline.queues(),
            queue.len(),
            queue.capacity(),
            self.contexts - self.free,
            self.contexts,
            self.leaving.len()
        )
    }
}
