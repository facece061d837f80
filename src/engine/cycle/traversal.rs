//! The traversal unit.

use std::collections::VecDeque;

use super::ray::Id;
use super::unit::{Pace, Unit};
use super::wires::Wires;
use crate::machine::traversal::TraversalSpec;
use crate::machine::writes::WritePolicy;
use crate::stream::{RayKind, Step};

pub struct Traversal {
    index: usize,
    pub unit: Unit,
    /// Rays that leave for list or intersection units.
    leaving: VecDeque<Id>,
    /// Rays that wait for the out FIFO.
    done: VecDeque<Id>,
}

impl Traversal {
    pub fn new(spec: &TraversalSpec, index: usize, line: u64) -> Self {
        let pace = Pace { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        let unit = Unit::new(index, &spec.cache, pace, line, WritePolicy::Back);
        Self { index, unit, leaving: VecDeque::new(), done: VecDeque::new() }
    }

    pub fn tick(&mut self, now: u64, wires: &mut Wires) {
        self.unit.fill_and_hit(now, wires);
        if let Some(id) = self.unit.leave(now) {
            let ray = wires.ray(id);
            ray.path.pop_front();
            match ray.kind {
                RayKind::Primary | RayKind::Reflection | RayKind::Refraction => wires.replayed.node_visits += 1,
                RayKind::Shadow => wires.replayed.shadow_node_visits += 1,
            }
            self.next_step(id, now, wires);
        }
        while let Some(id) = wires.back_in_traversal[self.index].take(now) {
            self.next_step(id, now, wires);
        }
        while let Some(id) = wires.dispatched[self.index].take(now) {
            self.next_step(id, now, wires);
        }
        while let Some(&id) = self.done.front()
            && wires.send_out(now, id)
        {
            self.done.pop_front();
            wires.freed_slots.put(now, self.index);
        }
        let began = self.unit.begin(now, &wires.layout);
        self.unit.access(now);
        if let Some(&id) = self.leaving.front() {
            let sent = match wires.ray(id).path.front() {
                Some(Step::List(_)) => wires.send_to_list(now, id),
                _ => wires.send_to_test(now, id),
            };
            if sent {
                self.leaving.pop_front();
            }
        }
        self.unit.send(now, wires);
        self.unit.account(now, began, !self.leaving.is_empty() || !self.done.is_empty(), false);
    }

    fn next_step(&mut self, id: Id, now: u64, wires: &mut Wires) {
        let ray = wires.ray(id);
        match ray.path.front() {
            Some(&Step::Node(node)) => self.unit.fetch(id, wires.layout.node(node), &wires.layout),
            Some(_) => self.leaving.push_back(id),
            None => {
                wires.path_done(id);
                if wires.ray(id).policy.is_empty() {
                    self.done.push_back(id);
                } else {
                    wires.send_to_policy(now, id);
                    wires.freed_slots.put(now, self.index);
                }
            }
        }
    }

    pub fn queues(&self) -> String {
        format!("{}, leaving for lists or intersection {}", self.unit.queues(), self.leaving.len())
    }
}
