//! The intersection unit.

use std::collections::VecDeque;

use super::ray::{Id, Sender};
use super::unit::{Pace, Unit};
use super::wires::Wires;
use crate::machine::intersection::IntersectionSpec;
use crate::machine::writes::WritePolicy;
use crate::stream::{RayKind, Step, Stop};

pub(super) struct Intersection {
    index: usize,
    pub unit: Unit,
    /// Rays that leave for a division unit.
    leaving: VecDeque<Id>,
    contexts: usize,
    in_work: usize,
}

impl Intersection {
    pub(super) fn new(spec: &IntersectionSpec, writes: WritePolicy, index: usize, l1: usize, line: u64) -> Self {
        let pace = Pace { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        Self {
            index,
            unit: Unit::new(l1, &spec.cache, pace, line, writes),
            leaving: VecDeque::new(),
            contexts: spec.tests.size(),
            in_work: 0,
        }
    }

    pub(super) fn tick(&mut self, now: u64, wires: &mut Wires) {
        while wires.test_left[self.index].take(now).is_some() {
            self.in_work -= 1;
        }
        let a_context_was_free = self.in_work < self.contexts;
        self.unit.fill_and_hit(now, wires);
        if let Some(id) = self.unit.leave(now) {
            self.operation_ended(id, now, wires);
        }
        if a_context_was_free && let Some(id) = wires.tests[self.index].take(now) {
            self.in_work += 1;
            let ray = wires.ray(id);
            ray.at_edges = false;
            let element = match ray.tested_step().front() {
                Some(&Step::Triangle { slot, .. }) => wires.layout.plane(slot),
                Some(&Step::Read { store, index }) => wires.layout.entry(store, index, false),
                Some(&Step::Write { store, index } | &Step::Update { store, index }) => {
                    wires.layout.entry(store, index, true)
                }
                other => unreachable!("{other:?} is not for an intersection unit"),
            };
            self.unit.fetch(id, element, &wires.layout);
        }
        let began = self.unit.begin(now, &wires.layout);
        self.unit.access(now);
        if let Some(&id) = self.leaving.front()
            && wires.send_to_division(now, id)
        {
            self.leaving.pop_front();
        }
        self.unit.send(now, wires);
        self.unit.account(now, began, !self.leaving.is_empty(), false);
    }

    fn operation_ended(&mut self, id: Id, now: u64, wires: &mut Wires) {
        let ray = wires.ray(id);
        let divides = matches!(ray.sender, Sender::Traversal(_)) && ray.kind != RayKind::Shadow;
        match ray.tested_step().front().copied() {
            Some(Step::Triangle { slot, stop: Stop::Edges | Stop::Hit }) if !ray.at_edges => {
                ray.at_edges = true;
                self.unit.fetch(id, wires.layout.edges(slot), &wires.layout);
            }
            Some(Step::Triangle { stop: Stop::Hit, .. }) if divides => self.leaving.push_back(id),
            _ => {
                self.in_work -= 1;
                wires.test_is_over(now, id);
            }
        }
    }

    pub(super) fn queues(&self, wires: &Wires) -> String {
        format!(
            "{}, queue {}, tests {}/{}, leaving for division {}",
            self.unit.queues(),
            wires.tests[self.index].len(),
            self.in_work,
            self.contexts,
            self.leaving.len()
        )
    }
}
