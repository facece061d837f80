//! The traversal unit: fetches nodes and tests their boxes.

use std::collections::VecDeque;

use super::links::{Links, take};
use super::pipeline::{Pipeline, Stages};
use super::ray::RayId;
use crate::machine::parts::Parts;
use crate::machine::traversal::TraversalSpec;
use crate::machine::writes::WritePolicy;
use crate::memory::Wake;
use crate::stream::{RayKind, Step};

/// A traversal unit.
#[derive(Clone, Debug)]
pub struct Traversal {
    index: u32,
    /// The common part.
    pub pipeline: Pipeline,
    /// Rays that wait to go to a list or intersection unit.
    leaving: VecDeque<RayId>,
    /// Rays that are done and wait for the out FIFO.
    done: VecDeque<RayId>,
}

impl Traversal {
    /// Unit `index`, empty.
    pub fn new<W: Wake>(spec: &TraversalSpec, line: u64, index: u32, links: &Links<W>) -> Self {
        let part = links.parts.traversal(index);
        let stages = Stages { latency: spec.latency.get(), interval: spec.interval.get() };
        let core = links.parts.core(part);
        let pipeline = Pipeline::new(part, core, &spec.cache, stages, line, WritePolicy::Back);
        Self { index, pipeline, leaving: VecDeque::new(), done: VecDeque::new() }
    }

    /// Cycle `now`.
    pub fn tick(&mut self, now: u64, links: &mut Links<impl Wake>) {
        self.pipeline.arrive(now, links);
        if let Some(id) = self.pipeline.leave(now) {
            let ray = &mut links.rays[id as usize];
            ray.next += 1;
            match ray.kind {
                RayKind::Shadow => links.replayed.shadow_node_visits += 1,
                _ => links.replayed.node_visits += 1,
            }
            self.route(id, now, links);
        }
        while let Some(ray) = take(&mut links.returned[self.index as usize], now) {
            self.route(ray, now, links);
        }
        while let Some(ray) = take(&mut links.dispatched[self.index as usize], now) {
            self.route(ray, now, links);
        }
        let (core, part) = (self.pipeline.core(), self.pipeline.part());
        while self.done.front().is_some_and(|&id| links.send_out(id, part, now)) {
            self.done.pop_front();
            links.freed.push(self.index);
        }
        let began = self.pipeline.begin(now, &links.rays);
        let sent = self.leaving.front().is_some_and(|&id| match links.rays[id as usize].path_step() {
            Some(Step::List(_)) => links.send_to_list(id, core, part, now),
            _ => links.send_to_test(id, core, part, now),
        });
        if sent {
            self.leaving.pop_front();
        }
        self.pipeline.end(now, links, began, !self.leaving.is_empty() || !self.done.is_empty());
        if sent && !self.leaving.is_empty() {
            links.clock.wake(self.pipeline.part(), now + 1);
        }
        if let Some(&(at, _)) = links.dispatched[self.index as usize].front() {
            links.clock.wake(self.pipeline.part(), at);
        }
    }

    fn route(&mut self, id: RayId, now: u64, links: &mut Links<impl Wake>) {
        let ray = &links.rays[id as usize];
        match ray.path_step() {
            Some(Step::Node(node)) => {
                let element = links.layout.node(node);
                self.pipeline.fetch(id, &element, links);
            }
            Some(_) => self.leaving.push_back(id),
            None => {
                if ray.has_policy() {
                    links.freed.push(self.index);
                    links.send_to_shadow_cache(id, now);
                    links.clock.wake(Parts::DISPATCHER, now + 1);
                } else {
                    self.done.push_back(id);
                }
            }
        }
    }

    /// The state of the queues, for the report of a deadlock.
    pub fn queues(&self) -> String {
        format!("{}, leaving for lists or intersection {}", self.pipeline.queues(), self.leaving.len())
    }
}
