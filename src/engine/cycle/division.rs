//! The division unit.

use std::collections::VecDeque;

use super::ray::Id;
use super::wires::Wires;
use crate::machine::division::DivisionSpec;
use crate::stats::Cause;

pub(super) struct Division {
    index: usize,
    spec: DivisionSpec,
    stages: VecDeque<(u64, Id)>,
    last_began: Option<u64>,
    pub causes: [u64; Cause::ALL.len()],
}

impl Division {
    pub(super) fn new(spec: &DivisionSpec, index: usize) -> Self {
        Self { index, spec: *spec, stages: VecDeque::new(), last_began: None, causes: Default::default() }
    }

    pub(super) fn tick(&mut self, now: u64, wires: &mut Wires) {
        if let Some(&(at, id)) = self.stages.front()
            && at == now
        {
            self.stages.pop_front();
            let unit = wires.test_unit(id);
            wires.test_left[unit].put(now, ());
            wires.test_is_over(now, id);
        }
        let interval = self.spec.interval.get();
        let occupied = self.last_began.is_some_and(|began| now - began < interval);
        if !occupied && let Some(id) = wires.divisions[self.index].take(now) {
            self.stages.push_back((now + self.spec.latency.get(), id));
            self.last_began = Some(now);
        }
        let cause = if self.last_began.is_some_and(|began| now - began < interval) {
            Cause::Busy
        } else if self.stages.is_empty() {
            Cause::Starved
        } else {
            Cause::Pipeline
        };
        self.causes[cause as usize] += 1;
    }

    pub(super) fn queues(&self, wires: &Wires) -> String {
        format!("in the pipeline {}, queue {}", self.stages.len(), wires.divisions[self.index].len())
    }
}
