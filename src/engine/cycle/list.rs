//! The list unit.

use std::collections::VecDeque;

use super::ray::Id;
use super::unit::{Pace, Unit};
use super::wires::Wires;
use crate::machine::list::ListSpec;
use crate::machine::writes::WritePolicy;
use crate::stream::Step;

pub struct List {
    index: usize,
    pub unit: Unit,
    leaving: VecDeque<Id>,
    contexts: usize,
    in_work: usize,
}

impl List {
    pub fn new(spec: &ListSpec, index: usize, l1: usize, line: u64) -> Self {
        let pace = Pace { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 };
        Self {
            index,
            unit: Unit::new(l1, &spec.cache, pace, line, WritePolicy::Back),
            leaving: VecDeque::new(),
            contexts: spec.lists.size(),
            in_work: 0,
        }
    }

    pub fn tick(&mut self, now: u64, wires: &mut Wires) {
        while wires.list_left[self.index].take(now).is_some() {
            self.in_work -= 1;
        }
        let a_context_was_free = self.in_work < self.contexts;
        self.unit.fill_and_hit(now, wires);
        if let Some(id) = self.unit.leave(now) {
            wires.ray(id).path.pop_front();
            wires.replayed.list_reads += 1;
            self.next_step(id, now, wires);
        }
        while let Some(id) = wires.back_in_list[self.index].take(now) {
            self.next_step(id, now, wires);
        }
        if a_context_was_free && let Some(id) = wires.lists[self.index].take(now) {
            self.in_work += 1;
            wires.ray(id).list = Some(self.index);
            self.next_step(id, now, wires);
        }
        let began = self.unit.begin(now, &wires.layout);
        self.unit.access(now);
        if let Some(&id) = self.leaving.front()
            && wires.send_to_test(now, id)
        {
            self.leaving.pop_front();
        }
        self.unit.send(now, wires);
        self.unit.account(now, began, !self.leaving.is_empty(), false);
    }

    fn next_step(&mut self, id: Id, now: u64, wires: &mut Wires) {
        let ray = wires.ray(id);
        match ray.path.front() {
            Some(&Step::List(entry)) => self.unit.fetch(id, wires.layout.list_entry(entry), &wires.layout),
            Some(Step::Triangle { .. }) => self.leaving.push_back(id),
            _ => {
                ray.list = None;
                self.in_work -= 1;
                wires.give_back(now, id);
            }
        }
    }

    pub fn queues(&self, wires: &Wires) -> String {
        format!(
            "{}, queue {}, lists {}/{}, leaving for intersection {}",
            self.unit.queues(),
            wires.lists[self.index].len(),
            self.in_work,
            self.contexts,
            self.leaving.len()
        )
    }
}
