//! The division unit, the second stage of intersection: the distance of a hit (IST2 of the T&I engine).

use super::causes::Causes;
use super::links::{Inbox, Links, take};
use super::pipeline::Stages;
use super::ray::{FREES_LIST, GONE, RayId};
use crate::machine::division::DivisionSpec;
use crate::memory::{PartId, Wake};
use crate::stats::Cause;

/// A division unit.
#[derive(Clone, Debug)]
pub(crate) struct Division {
    index: usize,
    part: PartId,
    core: u32,
    timing: Stages,
    stages: Inbox<RayId>,
    /// The first cycle in which an operation can begin.
    open_at: u64,
    /// The unit's cycles.
    pub causes: Causes,
}

impl Division {
    /// Unit `index`, empty.
    pub(crate) fn new(spec: &DivisionSpec, index: u32, links: &Links) -> Self {
        let part = links.parts.division(index);
        Self {
            index: index as usize,
            part,
            core: links.parts.core(part),
            timing: Stages { latency: spec.latency.get(), interval: spec.interval.get(), width: 1 },
            stages: Inbox::new(),
            open_at: 0,
            causes: Causes::default(),
        }
    }

    /// Acts in cycle `now`.
    pub(crate) fn tick(&mut self, now: u64, links: &mut Links) {
        if let Some(id) = take(&mut self.stages, now) {
            let unit = links.parts.intersection_of(self.core, (id & !(GONE | FREES_LIST)).into());
            links.freed_tests[unit as usize] += 1;
            let part = links.parts.intersection(unit);
            links.clock.wake(part, now + 1);
            if id & GONE != 0 {
                links.left(id, self.core, now);
            } else {
                links.tested(id, now);
            }
        }
        if now >= self.open_at
            && let Some(id) = links.divisions[self.index].take(now, &mut links.clock)
        {
            let ends = now + self.timing.latency;
            let left = links.tested_ahead(id, self.part, ends);
            self.stages.push_back((ends, left));
            self.open_at = now + self.timing.interval;
            self.causes.begin(now, self.timing.interval);
        }
        let idle = if self.stages.is_empty() { Cause::Starved } else { Cause::Pipeline };
        self.causes.cycle(now, idle);
        if let Some(&(at, _)) = self.stages.front() {
            links.clock.wake(self.part, at);
        }
        if let Some(at) = links.divisions[self.index].next_at() {
            links.clock.wake(self.part, at.max(self.open_at).max(now + 1));
        }
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self, links: &Links) -> String {
        let queue = &links.divisions[self.index];
        format!("in the pipeline {}, queue {}/{}", self.stages.len(), queue.len(), queue.capacity())
    }
}
