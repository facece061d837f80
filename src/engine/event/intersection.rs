//! The intersection unit: fetches triangle records in two phases and tests them.

use super::links::Links;
use super::pipeline::{Pipeline, Stages};
use super::ray::{Owner, RayId};
use crate::machine::intersection::IntersectionSpec;
use crate::machine::writes::WritePolicy;
use crate::memory::Wake;
use crate::memory::ring::Ring;
use crate::stream::{RayKind, Step, Stop};

/// An intersection unit.
#[derive(Clone, Debug)]
pub struct Intersection {
    index: usize,
    /// The common part.
    pub pipeline: Pipeline,
    /// Rays that wait to go to a division unit.
    leaving: Ring<RayId>,
    contexts: usize,
    free: usize,
}

impl Intersection {
    /// Unit `index`, empty; `writes` says what becomes of writes to entries of stores, if they come this way.
    pub fn new(spec: &IntersectionSpec, writes: WritePolicy, line: u64, index: u32, links: &Links) -> Self {
        let part = links.parts.intersection(index);
        let stages = Stages { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        Self {
            index: index as usize,
            pipeline: Pipeline::new(part, links.parts.core(part), &spec.cache, stages, line, writes),
            leaving: Ring::new(),
            contexts: spec.tests.size(),
            free: spec.tests.size(),
        }
    }

    /// Cycle `now`.
    pub fn tick(&mut self, now: u64, links: &mut Links) {
        self.free += std::mem::take(&mut links.freed_tests[self.index]);
        let free_at_start = self.free > 0;
        self.pipeline.arrive(now, links);
        if let Some(id) = self.pipeline.leave(now) {
            self.passed(id, now, links);
        }
        if free_at_start && let Some(id) = links.tests[self.index].take(now, &mut links.clock) {
            self.free -= 1;
            self.take_on(id, links);
        }
        let began = self.pipeline.begin(now, &links.rays);
        let (core, part) = (self.pipeline.core(), self.pipeline.part());
        let sent = self.leaving.front().is_some_and(|&id| links.send_to_division(id, core, part, now));
        if sent {
            self.leaving.pop_front();
        }
        self.pipeline.end(now, links, began, !self.leaving.is_empty());
        if sent && !self.leaving.is_empty() {
            links.clock.wake(part, now + 1);
        }
        if self.free > 0
            && let Some(at) = links.tests[self.index].next_at()
        {
            links.clock.wake(part, at.max(now + 1));
        }
    }

    fn take_on(&mut self, id: RayId, links: &mut Links) {
        let ray = &mut links.rays[id as usize];
        ray.at_edges = false;
        let element = match ray.step() {
            Some(Step::Triangle { slot, .. }) => links.layout.plane(slot),
            Some(step) if step.entry().is_some() => links.entry_element(id),
            step => unreachable!("{step:?} is not for an intersection unit"),
        };
        self.pipeline.fetch(id, &element, links);
    }

    /// An operation of the ray has ended.
    fn passed(&mut self, id: RayId, now: u64, links: &mut Links) {
        let ray = &mut links.rays[id as usize];
        let Some(Step::Triangle { slot, stop }) = ray.step() else { return self.give_back(id, now, links) };
        if stop != Stop::Plane && !ray.at_edges {
            ray.at_edges = true;
            let element = links.layout.edges(slot);
            self.pipeline.fetch(id, &element, links);
        } else if stop == Stop::Hit && ray.kind != RayKind::Shadow && matches!(ray.owner, Owner::Traversal(_)) {
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
    pub fn queues(&self, links: &Links) -> String {
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
