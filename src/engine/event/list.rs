//! The list unit: reads the entries of primitive lists in the leaves of a kd-tree, and sends their triangles to be
//! tested.

use super::links::{Links, take};
use super::memory::Memory;
use super::pipeline::{Pipeline, Stages};
use super::ray::{GONE, Owner, RayId};
use crate::machine::list::ListSpec;
use crate::machine::writes::WritePolicy;
use crate::memory::ring::Ring;
use crate::stream::Step;

/// A list unit.
#[derive(Clone, Debug)]
pub(crate) struct List {
    index: u32,
    /// The common part.
    pub pipeline: Pipeline,
    /// Rays that wait to go to an intersection unit.
    leaving: Ring<RayId>,
    contexts: usize,
    free: usize,
    /// Number of operations, from the pipeline's front on, that [`List::send_back`] has handled.
    known: usize,
}

impl List {
    /// Unit `index`, empty.
    pub(crate) fn new(spec: &ListSpec, memory: Memory, index: u32, links: &Links) -> Self {
        let part = links.parts.list(index);
        let stages = Stages { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        Self {
            index,
            pipeline: Pipeline::new(part, links.parts.core(part), &spec.cache, stages, WritePolicy::Back, memory),
            leaving: Ring::new(),
            contexts: spec.lists.size(),
            free: spec.lists.size(),
            known: 0,
        }
    }

    /// Acts in cycle `now`.
    pub(crate) fn tick(&mut self, now: u64, links: &mut Links) {
        let index = self.index as usize;
        self.free += std::mem::take(&mut links.freed_lists[index]);
        let free_at_start = self.free > 0;
        self.pipeline.arrive(now, links);
        if let Some(id) = self.pipeline.leave(now) {
            links.replayed.list_reads += 1;
            self.known -= 1;
            if id & GONE != 0 {
                self.free += 1;
            } else {
                links.rays[id as usize].steps.advance();
                self.route(id, now, links);
            }
        }
        while let Some(id) = take(&mut links.listed[index], now) {
            self.route(id, now, links);
        }
        if free_at_start && let Some(id) = links.lists[index].take(now, &mut links.clock) {
            self.free -= 1;
            links.rays[id as usize].list = Some(self.index);
            self.route(id, now, links);
        }
        self.pipeline.begin(now, &links.rays);
        let part = self.pipeline.part();
        let sent = self.leaving.front().is_some_and(|&id| links.send_to_test(id, self.pipeline.core(), part, now));
        if sent {
            self.leaving.pop_front();
        }
        let mut next = self.pipeline.end(now, links, !self.leaving.is_empty());
        self.send_back(links);
        if sent && !self.leaving.is_empty() {
            next = now + 1;
        }
        if self.free > 0
            && let Some(at) = links.lists[index].next_at()
        {
            next = next.min(at.max(now + 1));
        }
        links.clock.wake_if(part, next.min(self.pipeline.ends_at()));
    }

    /// Sends back rays that have begun to read the last entry of their list.
    fn send_back(&mut self, links: &mut Links) {
        let part = self.pipeline.part();
        while let Some((ends, id)) = self.pipeline.operation(self.known) {
            let ray = &mut links.rays[*id as usize];
            if !ray.stays_in_list()
                && let Owner::Traversal(unit) = ray.owner
            {
                ray.steps.advance();
                ray.list = None;
                links.send_back(*id, unit, part, *ends);
                *id |= GONE;
            }
            self.known += 1;
        }
    }

    fn route(&mut self, id: RayId, now: u64, links: &mut Links) {
        match links.rays[id as usize].path_step() {
            Some(Step::List(entry)) => {
                let element = links.layout.list_entry(entry);
                self.pipeline.fetch(id, &element, now, links);
            }
            Some(Step::Triangle { .. }) => self.leaving.push_back(id),
            step => unreachable!("{step:?} is not for a list unit"),
        }
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self, links: &Links) -> String {
        let queue = &links.lists[self.index as usize];
        format!(
            "{}, queue {}/{}, lists {}/{}, leaving for intersection {}",
            self.pipeline.queues(),
            queue.len(),
            queue.capacity(),
            self.contexts - self.free,
            self.contexts,
            self.leaving.len()
        )
    }
}
