//! The shadow-cache units: perform the recorded steps of the culling policy (reads and writes of its stores, occlusion
//! tests), and the decisions for skipped rays.

use crate::memory::ring::Ring;
use std::collections::VecDeque;

use super::links::{Links, take};
use super::memory::Memory;
use super::pipeline::{Pipeline, Stages};
use super::ray::{Owner, RayId};
use crate::engine::register::{Kept, Register};
use crate::machine::parts::Parts;
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};
use crate::machine::writes::WritePolicy;
use crate::memory::Wake;
use crate::stream::{Step, Store};

/// A unit's share of an end-of-frame update that is under way.
#[derive(Clone, Debug)]
struct Ending {
    /// Steps to begin; the flag says whether the step is sent down as an operand.
    steps: VecDeque<(Step, bool)>,
    left: usize,
}

/// A shadow-cache unit.
#[derive(Clone, Debug)]
pub(crate) struct ShadowCache {
    index: u32,
    place: Place,
    /// The common part.
    pub pipeline: Pipeline,
    register: Register,
    /// Rays that wait to go to an intersection unit.
    leaving: Ring<RayId>,
    /// Rays that are done and wait for the out FIFO.
    done: Ring<RayId>,
    contexts: usize,
    free: usize,
    /// Number of rays that it can take in a cycle.
    width: usize,
    /// The first entry after the pool's; end-of-frame steps use the entries from here on.
    first_entry: RayId,
    free_entries: Ring<RayId>,
    ending: Option<Ending>,
}

impl ShadowCache {
    /// Unit `index`, empty, of a machine whose pool has `pool` entries.
    pub(crate) fn new(spec: &ShadowCacheSpec, memory: Memory, pool: u64, index: u32, links: &Links) -> Self {
        let part = links.parts.shadow_cache(index);
        let writes = if spec.place == Place::L2 { WritePolicy::Through } else { spec.writes };
        let first_entry = pool as RayId;
        let contexts = spec.contexts.get() as RayId;
        let own_entries = first_entry + index * contexts;
        let stages = Stages { latency: spec.latency.get(), interval: spec.interval.get(), width: spec.width.get() };
        let mut pipeline = Pipeline::new(part, links.parts.core(part), &spec.cache, stages, writes, memory);
        // Decisions, and entries that intersection units accessed, become ready without a fetch.
        pipeline.foresee_nothing();
        Self {
            index,
            place: spec.place,
            pipeline,
            register: Register::new(spec.register.size()),
            leaving: Ring::new(),
            done: Ring::new(),
            contexts: spec.contexts.size(),
            free: spec.contexts.size(),
            width: spec.width.size(),
            first_entry,
            free_entries: (own_entries..own_entries + contexts).collect(),
            ending: None,
        }
    }

    /// Acts in cycle `now`.
    pub(crate) fn tick(&mut self, now: u64, links: &mut Links) {
        let free_at_start = self.free;
        self.pipeline.arrive(now, links);
        while let Some(id) = self.pipeline.leave(now) {
            self.passed(id, now, links);
        }
        while let Some(id) = take(&mut links.back_in_policy[self.index as usize], now) {
            if std::mem::take(&mut links.rays[id as usize].fetched) {
                self.pipeline.ready(id, links);
            } else {
                self.route(id, now, links);
            }
        }
        self.hear_of_the_end(now, links);
        let taken = (0..self.width.min(free_at_start)).take_while(|_| self.take_on(now, links)).count();
        let passed_by = taken == self.width && taken < free_at_start && self.more_wait(now, links);
        let part = self.pipeline.part();
        while self.done.front().is_some_and(|&id| links.send_out(id, part, now)) {
            self.done.pop_front();
            self.free += 1;
        }
        let began = self.pipeline.begin_several(now, &links.rays);
        let core = self.pipeline.core();
        let sent = self.leaving.front().is_some_and(|&id| match links.rays[id as usize].step() {
            Some(Step::Triangle { .. }) => links.send_to_test(id, core, part, now),
            _ => links.send_to_access(id, part, now),
        });
        if sent {
            self.leaving.pop_front();
        }
        let leaving = !self.leaving.is_empty() || !self.done.is_empty();
        let next = if passed_by && !began {
            self.pipeline.end_crowded(now, links, leaving, true)
        } else {
            self.pipeline.end(now, links, leaving)
        };
        let to_come = !links.retired[self.index as usize].is_empty()
            || self.ending.as_ref().is_some_and(|ending| !ending.steps.is_empty());
        let more = sent && !self.leaving.is_empty() || self.free > 0 && to_come;
        links.clock.wake_if(part, if more { now + 1 } else { next.min(self.pipeline.ends_at()) });
    }

    fn hear_of_the_end(&mut self, now: u64, links: &mut Links) {
        let Some(planned) = links.hear_of_the_end(self.index, now) else { return };
        let waiting = self.register.drain().map(|step| (step, true));
        let steps: VecDeque<_> = waiting.chain(planned.into_iter().map(|step| (step, false))).collect();
        let left = steps.len();
        self.ending = Some(Ending { steps, left });
        self.end_if_done(now, links);
    }

    fn end_if_done(&mut self, now: u64, links: &mut Links) {
        if self.ending.as_ref().is_some_and(|ending| ending.left == 0) {
            self.ending = None;
            links.units_at_the_end -= 1;
            if links.units_at_the_end == 0 {
                links.frame_over = true;
                links.clock.wake(Parts::DISPATCHER, now + 1);
            }
        }
    }

    /// Whether a ray that has arrived, or an end-of-frame step, waits in front of the unit.
    fn more_wait(&self, now: u64, links: &Links) -> bool {
        links.retired[self.index as usize].front().is_some_and(|&(at, _)| at <= now)
            || self.ending.as_ref().is_some_and(|ending| !ending.steps.is_empty())
    }

    /// Takes on a ray or an end-of-frame step. Returns whether there was one.
    fn take_on(&mut self, now: u64, links: &mut Links) -> bool {
        if let Some(id) = take(&mut links.retired[self.index as usize], now) {
            self.free -= 1;
            let ray = &mut links.rays[id as usize];
            ray.owner = Owner::ShadowCache(self.index);
            if ray.undecided {
                self.pipeline.ready(id, links)
            } else {
                self.route(id, now, links)
            }
            true
        } else if let Some(ending) = &mut self.ending
            && let Some(&id) = self.free_entries.front()
            && let Some((step, operand)) = ending.steps.pop_front()
        {
            self.free_entries.pop_front();
            self.free -= 1;
            let ray = &mut links.rays[id as usize];
            (ray.undecided, ray.owner) = (false, Owner::ShadowCache(self.index));
            ray.operand = operand;
            ray.steps.begin(&[], &[step.pack()]);
            self.route(id, now, links);
            true
        } else {
            false
        }
    }

    /// An operation of the ray has ended.
    fn passed(&mut self, id: RayId, now: u64, links: &mut Links) {
        let ray = &mut links.rays[id as usize];
        if ray.undecided {
            ray.undecided = false;
        } else {
            let step = ray.step();
            ray.steps.advance();
            ray.evaluating = ray.evaluating.saturating_sub(1);
            links.replayed.count_policy(step.into_iter());
            if let Some(Step::Read { store, index }) = step
                && store != Store::OccluderId
                && id < self.first_entry
            {
                self.register.was_read(links.layout.entry(store, index, false).addr);
            }
        }
        self.route(id, now, links);
    }

    /// Starts the next step of a ray; steps that the register answers or keeps are done at once.
    fn route(&mut self, id: RayId, now: u64, links: &mut Links) {
        loop {
            let Some(step) = links.rays[id as usize].step() else { return self.finish(id, now, links) };
            let Some((store, index)) = step.entry() else {
                let element = match step {
                    Step::Node(node) => links.layout.node(node),
                    Step::List(entry) => links.layout.list_entry(entry),
                    _ => return self.leaving.push_back(id),
                };
                return self.pipeline.fetch(id, &element, now, links);
            };
            let home = links.home(store, index);
            if home != self.index {
                self.free += 1;
                return links.pass_on(id, home, now);
            }
            let of_a_ray = id < self.first_entry;
            if of_a_ray && links.first_touch(id) {
                continue;
            }
            let ray = &mut links.rays[id as usize];
            let sets_modes = ray.evaluating > 0 || !of_a_ray && !ray.operand;
            if of_a_ray && !sets_modes && self.register.is_there() && store != Store::OccluderId {
                let addr = links.layout.entry(store, index, false).addr;
                let done = if matches!(step, Step::Read { .. }) {
                    let answered = self.register.answers(addr);
                    links.stores.merged_reads += u64::from(answered);
                    answered
                } else {
                    match self.register.keep(addr, step) {
                        Kept::Merged => {
                            links.stores.merged_writes += 1;
                            true
                        }
                        Kept::Waits => true,
                        Kept::InPlaceOf(other) => {
                            ray.steps.change(|steps, _, next| steps[next] = other.pack());
                            false
                        }
                    }
                };
                if done {
                    ray.steps.advance();
                    continue;
                }
            }
            return self.access(id, sets_modes, now, links);
        }
    }

    /// Accesses the entry of the ray's next step.
    fn access(&mut self, id: RayId, sets_modes: bool, now: u64, links: &mut Links) {
        let element = links.entry_element(id);
        match self.place {
            Place::Triangle => self.leaving.push_back(id),
            Place::L2 if element.write && !sets_modes => self.pipeline.ready_to_write(id, &element, links),
            Place::L2 => self.pipeline.fetch_bypass(id, &element, links),
            Place::Own | Place::Free => self.pipeline.fetch(id, &element, now, links),
        }
    }

    fn finish(&mut self, id: RayId, now: u64, links: &mut Links) {
        if id < self.first_entry {
            return self.done.push_back(id);
        }
        self.free += 1;
        self.free_entries.push_back(id);
        if let Some(ending) = &mut self.ending {
            ending.left -= 1;
        }
        self.end_if_done(now, links);
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self, links: &Links) -> String {
        format!(
            "{}, to come {}, contexts {}/{}, leaving for intersection {}",
            self.pipeline.queues(),
            links.retired[self.index as usize].len(),
            self.contexts - self.free,
            self.contexts,
            self.leaving.len()
        )
    }
}
