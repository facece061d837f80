//! The intersection unit.

use std::collections::VecDeque;

use super::ray::{Id, Sender};
use super::unit::Unit;
use super::wires::Wires;
use crate::machine::intersection::IntersectionSpec;
use crate::machine::pipeline::WritePolicy;
use crate::stream::{RayKind, Step, Stop};

pub struct Intersection {
    index: usize,
    pub unit: Unit,
    divide_latency: u64,
    divider: VecDeque<(u64, Id)>,
    contexts: usize,
    in_work: usize,
}

impl Intersection {
    pub fn new(spec: &IntersectionSpec, writes: WritePolicy, index: usize, l1: usize, line: u64) -> Self {
        Self {
            index,
            unit: Unit::new(l1, &spec.cache, spec.latency.get(), line, writes),
            divide_latency: spec.divide_latency.get(),
            divider: VecDeque::new(),
            contexts: spec.tests.size(),
            in_work: 0,
        }
    }

    pub fn tick(&mut self, now: u64, wires: &mut Wires) {
        let a_context_was_free = self.in_work < self.contexts;
        self.unit.fill_and_hit(now, wires);
        if let Some(id) = self.unit.leave(now) {
            self.operation_ended(id, now, wires);
        }
        if let Some(&(at, id)) = self.divider.front()
            && at == now
        {
            self.divider.pop_front();
            self.give_back(id, now, wires);
        }
        if a_context_was_free && let Some(id) = wires.tests[self.index].take(now) {
            self.in_work += 1;
            let ray = wires.ray(id);
            ray.at_edges = false;
            let element = match ray.tested_step().front() {
                Some(&Step::Triangle { slot, .. }) => wires.layout.plane(slot),
                Some(&Step::List(entry)) => wires.layout.list_entry(entry),
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
        self.unit.send(now, wires);
        self.unit.account(began, false, !self.divider.is_empty());
    }

    fn operation_ended(&mut self, id: Id, now: u64, wires: &mut Wires) {
        let ray = wires.ray(id);
        let divides = matches!(ray.sender, Sender::Traversal(_)) && ray.kind != RayKind::Shadow;
        match ray.tested_step().front().copied() {
            Some(Step::Triangle { slot, stop: Stop::Edges | Stop::Hit }) if !ray.at_edges => {
                ray.at_edges = true;
                self.unit.fetch(id, wires.layout.edges(slot), &wires.layout);
            }
            Some(Step::Triangle { stop: Stop::Hit, .. }) if divides => {
                self.divider.push_back((now + self.divide_latency, id));
            }
            _ => self.give_back(id, now, wires),
        }
    }

    fn give_back(&mut self, id: Id, now: u64, wires: &mut Wires) {
        self.in_work -= 1;
        let ray = wires.ray(id);
        let (sender, kind) = (ray.sender, ray.kind);
        if let (Sender::ShadowCache(index), Some(Step::Read { .. } | Step::Write { .. } | Step::Update { .. })) =
            (sender, ray.tested_step().front())
        {
            // Only the access was made here.
            ray.accessed = true;
            wires.tested_for_policy[index].put(now, id);
            return;
        }
        let step = ray.tested_step().pop_front();
        let counted = match (step, sender, kind) {
            (Some(Step::List(_)), ..) => &mut wires.replayed.list_reads,
            (_, Sender::ShadowCache(_), _) => &mut wires.replayed.policy_triangle_tests,
            (_, Sender::Traversal(_), RayKind::Shadow) => &mut wires.replayed.shadow_triangle_tests,
            (_, Sender::Traversal(_), _) => &mut wires.replayed.triangle_tests,
        };
        *counted += 1;
        match sender {
            Sender::Traversal(index) => wires.tested[index].put(now, id),
            Sender::ShadowCache(index) => wires.tested_for_policy[index].put(now, id),
        }
    }

    pub fn queues(&self, wires: &Wires) -> String {
        format!(
            "{}, queue {}, tests {}/{}, in the divider {}",
            self.unit.queues(),
            wires.tests[self.index].len(),
            self.in_work,
            self.contexts,
            self.divider.len()
        )
    }
}
