//! The traversal unit: fetches nodes and tests their boxes.

use super::links::{Links, take};
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
pub struct Traversal {
    index: u32,
    /// The common part.
    pub pipeline: Pipeline,
    /// Rays that wait to go to a list or intersection unit.
    leaving: Ring<RayId>,
    /// Rays that are done and wait for the out FIFO.
    done: Ring<RayId>,
}

impl Traversal {
    /// Unit `index`, empty.
    pub fn new(spec: &TraversalSpec, line: u64, index: u32, links: &Links) -> Self {
        let part = links.parts.traversal(index);
        let stages = Stages { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        let core = links.parts.core(part);
        let pipeline = Pipeline::new(part, core, &spec.cache, stages, line, WritePolicy::Back);
        Self { index, pipeline, leaving: Ring::new(), done: Ring::new() }
    }

    /// Cycle `now`.
    pub fn tick(&mut self, now: u64, links: &mut Links) {
        let part = self.pipeline.part();
        let mail = links.mail[part.0 as usize];
        if mail > now + 1 && self.leaving.is_empty() && self.done.is_empty() && self.visit_at_once(now, mail, links) {
            return;
        }
        self.pipeline.arrive(now, links);
        if let Some(id) = self.pipeline.leave(now) {
            let ray = &mut links.rays[id as usize];
            ray.next += 1;
            links.replayed.count_visit(ray.kind);
            self.route(id, now, links);
        }
        if mail <= now {
            self.take_mail(now, links);
        }
        while self.done.front().is_some_and(|&id| links.send_out(id, part, now)) {
            self.done.drop_front();
            links.freed.push(self.index);
        }
        let began = self.pipeline.begin(now, &links.rays);
        let sent = !self.leaving.is_empty() && self.send(now, links);
        self.pipeline.end(now, links, began, !self.leaving.is_empty() || !self.done.is_empty());
        if sent && !self.leaving.is_empty() {
            links.clock.wake(part, now + 1);
        }
    }

    /// Most cycles of a unit that is not crowded: an operation ends, and its ray visits another node, whose line is there. Then the next operation
    /// of the ray begins in the next cycle, and nothing else happens in either. Whether it is so; if not, nothing was done.
    #[inline]
    fn visit_at_once(&mut self, now: u64, mail: u64, links: &mut Links) -> bool {
        let Some(id) = self.pipeline.leaves_alone(now) else { return false };
        let ray = &mut links.rays[id as usize];
        let Some(node) = ray.node_after() else { return false };
        let element = links.layout.node(node);
        let Some(at) = self.pipeline.fetch_at_once(id, &element, &links.layout, now) else { return false };
        ray.next += 1;
        links.replayed.count_visit(ray.kind);
        links.clock.wake(self.pipeline.part(), at.min(mail));
        true
    }

    /// Takes the rays that have come, and finds out when the next of what is on its way comes.
    fn take_mail(&mut self, now: u64, links: &mut Links) {
        let index = self.index as usize;
        while let Some(ray) = take(&mut links.returned[index], now) {
            self.route(ray, now, links);
        }
        while let Some(ray) = take(&mut links.dispatched[index], now) {
            self.route(ray, now, links);
        }
        let rays = [&links.returned[index], &links.dispatched[index]].map(|inbox| inbox.front().map(|&(at, _)| at));
        let part = self.pipeline.part();
        let line = links.lines[part.0 as usize].front().map(|line| line.at);
        let next = rays.into_iter().chain([line]).flatten().min();
        links.mail[part.0 as usize] = next.unwrap_or(u64::MAX);
        if let Some(at) = next.filter(|&at| at > now) {
            links.clock.wake(part, at);
        }
    }

    /// The first ray that leaves goes to a list or an intersection unit; whether it found a place.
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
                self.pipeline.fetch(id, &element, links);
            }
            Some(_) => self.leaving.push_back(id),
            None => self.retire(id, now, links),
        }
    }

    /// The path of a ray is done.
    fn retire(&mut self, id: RayId, now: u64, links: &mut Links) {
        links.retire(id);
        if links.rays[id as usize].has_policy() {
            links.freed.push(self.index);
            links.send_to_shadow_cache(id, now);
            links.clock.wake(Parts::DISPATCHER, now + 1);
        } else {
            self.done.push_back(id);
        }
    }

    /// The state of the queues, for the report of a deadlock.
    pub fn queues(&self) -> String {
        format!("{}, leaving for lists or intersection {}", self.pipeline.queues(), self.leaving.len())
    }
}
