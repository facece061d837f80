//! The shadow-cache unit.

use std::collections::VecDeque;

use super::ray::{Id, Ray, Sender};
use super::unit::Unit;
use super::wires::Wires;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::stream::{Decision, RayKind, Step};

pub struct ShadowCache {
    pub unit: Unit,
    leaving: VecDeque<Id>,
    contexts: usize,
    in_work: usize,
    /// Entries of the dispatcher's pool; those for a frame's end follow.
    pool: usize,
    free_entries: VecDeque<Id>,
    /// Steps of the frame's end that are not taken on yet, and how many are not done.
    end_steps: VecDeque<Step>,
    end_left: usize,
}

impl ShadowCache {
    pub fn new(spec: &ShadowCacheSpec, pool: usize, l1: usize, line: u64) -> Self {
        let contexts = spec.contexts.size();
        Self {
            unit: Unit::new(l1, &spec.cache, spec.latency.get(), line, spec.writes),
            leaving: VecDeque::new(),
            contexts,
            in_work: 0,
            pool,
            free_entries: (pool..pool + contexts).collect(),
            end_steps: VecDeque::new(),
            end_left: 0,
        }
    }

    pub fn tick(&mut self, now: u64, wires: &mut Wires) {
        let a_context_was_free = self.in_work < self.contexts;
        self.unit.fill_and_hit(now, wires);
        if let Some(id) = self.unit.leave(now) {
            let ray = wires.ray(id);
            if ray.undecided {
                ray.undecided = false;
            } else {
                let step = ray.policy.pop_front();
                wires.replayed.count_policy(step.into_iter());
            }
            self.next_step(id, now, wires);
        }
        while let Some(id) = wires.tested_for_policy.take(now) {
            self.next_step(id, now, wires);
        }
        while let Some(steps) = wires.frame_end.take(now) {
            self.end_left = steps.len();
            self.end_steps = Step::unpack_all(&steps).collect();
        }
        if a_context_was_free {
            self.take_on(now, wires);
        }
        let began = self.unit.begin(now, &wires.layout);
        self.unit.access(now);
        if let Some(&id) = self.leaving.front()
            && wires.send_to_test(now, id, id.checked_sub(self.pool).unwrap_or(id))
        {
            self.leaving.pop_front();
        }
        self.unit.send(now, wires);
        self.unit.account(began, !self.leaving.is_empty(), false);
    }

    /// Takes on one new ray, or step of a frame's end.
    fn take_on(&mut self, now: u64, wires: &mut Wires) {
        if let Some(id) = wires.retired.take(now) {
            self.in_work += 1;
            if wires.ray(id).undecided {
                self.unit.ready_without_fetch(id);
            } else {
                self.next_step(id, now, wires);
            }
        } else if let Some(step) = self.end_steps.pop_front() {
            self.in_work += 1;
            let id = self.free_entries.pop_front().expect("there are as many entries as contexts");
            wires.rays[id] = Some(Ray {
                kind: RayKind::Shadow,
                decision: Decision::Trace,
                path: VecDeque::new(),
                policy: VecDeque::from([step]),
                undecided: false,
                at_edges: false,
                sender: Sender::ShadowCache,
                origin: None,
            });
            self.next_step(id, now, wires);
        }
    }

    fn next_step(&mut self, id: Id, now: u64, wires: &mut Wires) {
        let ray = wires.ray(id);
        let element = match ray.policy.front().copied() {
            Some(Step::Triangle { .. }) => {
                ray.sender = Sender::ShadowCache;
                self.leaving.push_back(id);
                return;
            }
            Some(Step::Node(node)) => wires.layout.node(node),
            Some(Step::List(entry)) => wires.layout.list_entry(entry),
            Some(Step::Read { store, index }) => wires.layout.entry(store, index, false),
            Some(Step::Write { store, index } | Step::Update { store, index }) => {
                wires.layout.entry(store, index, true)
            }
            None => return self.ray_done(id, now, wires),
        };
        self.unit.fetch(id, element, &wires.layout);
    }

    fn ray_done(&mut self, id: Id, now: u64, wires: &mut Wires) {
        self.in_work -= 1;
        if id < self.pool {
            wires.done.put(now, id);
            return;
        }
        wires.rays[id] = None;
        self.free_entries.push_back(id);
        self.end_left -= 1;
        if self.end_left == 0 {
            wires.frame_over.put(now, ());
        }
    }

    pub fn queues(&self, wires: &Wires) -> String {
        format!(
            "{}, to come {}, contexts {}/{}, leaving for intersection {}, steps of the frame's end {}",
            self.unit.queues(),
            wires.retired.len(),
            self.in_work,
            self.contexts,
            self.leaving.len(),
            self.end_left
        )
    }
}
