//! The shadow-cache unit.

use std::collections::VecDeque;

use super::ray::{Id, Ray, Sender};
use super::unit::{Pace, Unit};
use super::wires::Wires;
use super::words::address;
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};
use crate::machine::writes::WritePolicy;
use crate::stream::{Decision, RayKind, Step, Store};

pub(super) struct ShadowCache {
    index: usize,
    spec: ShadowCacheSpec,
    pub unit: Unit,
    leaving: VecDeque<Id>,
    /// Rays that wait for the out FIFO.
    done: VecDeque<Id>,
    in_work: usize,
    /// Entries of the dispatcher's pool; the entries for end-of-frame steps follow.
    pool: usize,
    free_entries: VecDeque<Id>,
    /// The register: addresses of entries read, and waiting updates, both oldest first.
    read: Vec<u64>,
    waiting: Vec<Step>,
    /// End-of-frame steps not yet begun, each with whether it sets modes. `end_left` counts the steps not yet done
    /// during an end-of-frame update.
    end_steps: VecDeque<(Step, bool)>,
    end_left: Option<usize>,
}

/// What the register does with a step.
enum Registered {
    /// The register takes the step: nothing is to be performed.
    Done,
    /// This step is to be performed.
    Perform(Step),
}

impl ShadowCache {
    pub(super) fn new(spec: &ShadowCacheSpec, index: usize, pool: usize, l1: usize, line: u64) -> Self {
        let contexts = spec.contexts.size();
        let writes = if spec.place == Place::L2 { WritePolicy::Through } else { spec.writes };
        let first = pool + index * contexts;
        let pace = Pace { latency: spec.latency.get(), interval: spec.interval.get(), width: spec.width.get() };
        Self {
            index,
            spec: *spec,
            unit: Unit::new(l1, &spec.cache, pace, line, writes),
            leaving: VecDeque::new(),
            done: VecDeque::new(),
            in_work: 0,
            pool,
            free_entries: (first..first + contexts).collect(),
            read: Vec::new(),
            waiting: Vec::new(),
            end_steps: VecDeque::new(),
            end_left: None,
        }
    }

    pub(super) fn tick(&mut self, now: u64, wires: &mut Wires) {
        let free_contexts = self.spec.contexts.size() - self.in_work;
        self.unit.fill_and_hit(now, wires);
        while let Some(id) = self.unit.leave(now) {
            self.operation_ended(id, now, wires);
        }
        while let Some(id) = wires.back_in_policy[self.index].take(now) {
            if std::mem::replace(&mut wires.ray(id).accessed, false) {
                self.unit.ready_without_fetch(id);
            } else {
                self.go_on(id, now, wires);
            }
        }
        if let Some(steps) = wires.frame_end[self.index].take(now) {
            self.read.clear();
            self.end_steps.extend(self.waiting.drain(..).map(|step| (step, false)));
            self.end_steps.extend(steps.into_iter().map(|step| (step, true)));
            self.end_left = Some(self.end_steps.len());
            self.look_at_the_end(now, wires);
        }
        let width = self.spec.width.size();
        let taken = (0..width.min(free_contexts)).take_while(|_| self.take_on(now, wires)).count();
        let more_wait = wires.retired[self.index].first(now).is_some() || !self.end_steps.is_empty();
        let passed_by = taken == width && taken < free_contexts && more_wait;
        while let Some(&id) = self.done.front()
            && wires.send_out(now, id)
        {
            self.done.pop_front();
            self.in_work -= 1;
        }
        let began = self.unit.begin(now, &wires.layout);
        self.unit.access(now);
        if let Some(&id) = self.leaving.front() {
            let entry = wires.ray(id).policy.front().and_then(|step| step.entry());
            let sent = match entry {
                Some((store, index)) => wires.send_to_access(now, id, wires.layout.line_of(store, index)),
                None => wires.send_to_test(now, id),
            };
            if sent {
                self.leaving.pop_front();
            }
        }
        self.unit.send(now, wires);
        self.unit.account(now, began, !self.leaving.is_empty() || !self.done.is_empty(), passed_by);
    }

    fn operation_ended(&mut self, id: Id, now: u64, wires: &mut Wires) {
        let ray = wires.ray(id);
        if ray.undecided {
            ray.undecided = false;
        } else if let Some(step) = ray.policy.pop_front() {
            ray.setting = ray.setting.saturating_sub(1);
            wires.replayed.count_policy(std::iter::once(step));
            if let Step::Read { store: Store::ModeWord | Store::PixelCounter, .. } = step
                && id < self.pool
                && let Some(addr) = address(step, &wires.layout)
                && !self.read.contains(&addr)
            {
                self.read.push(addr);
                if self.read.len() > self.spec.register.size() {
                    self.read.remove(0);
                }
            }
        }
        self.go_on(id, now, wires);
    }

    /// Begins a new ray or end-of-frame step; returns whether there was one.
    fn take_on(&mut self, now: u64, wires: &mut Wires) -> bool {
        if let Some(id) = wires.retired[self.index].take(now) {
            self.in_work += 1;
            wires.ray(id).sender = Sender::ShadowCache(self.index);
            if wires.ray(id).undecided {
                self.unit.ready_without_fetch(id);
            } else {
                self.go_on(id, now, wires);
            }
            true
        } else if let Some((step, sets_modes)) = self.end_steps.pop_front() {
            self.in_work += 1;
            let id = self.free_entries.pop_front().expect("there are as many entries as contexts");
            wires.rays[id] = Some(Ray {
                kind: RayKind::Shadow,
                decision: Decision::Trace,
                path: VecDeque::new(),
                policy: VecDeque::from([step]),
                undecided: false,
                at_edges: false,
                setting: usize::from(sets_modes),
                accessed: false,
                sender: Sender::ShadowCache(self.index),
                list: None,
                handed_over: now,
                done: 0,
                unloaded: 0,
                origin: None,
            });
            self.go_on(id, now, wires);
            true
        } else {
            false
        }
    }

    /// Continues with the ray's next step.
    fn go_on(&mut self, id: Id, now: u64, wires: &mut Wires) {
        while let Some(&step) = wires.ray(id).policy.front() {
            match step {
                Step::Triangle { .. } => return self.leaving.push_back(id),
                Step::Node(node) => return self.unit.fetch(id, wires.layout.node(node), &wires.layout),
                Step::List(entry) => return self.unit.fetch(id, wires.layout.list_entry(entry), &wires.layout),
                Step::Read { .. } | Step::Write { .. } | Step::Update { .. } => {}
            }
            if let Some(home) = wires.words.home(step, &wires.layout).filter(|&home| home != self.index) {
                self.in_work -= 1;
                wires.retired[home].put(now, id);
                return;
            }
            if id >= self.pool {
                return self.access(id, step, wires);
            }
            if let Some(touch) = wires.words.first_touch(step, &wires.layout) {
                let ray = wires.ray(id);
                ray.policy.pop_front();
                touch.own.into_iter().for_each(|own| ray.policy.push_front(own));
                ray.setting = touch.setting.len();
                touch.setting.into_iter().rev().for_each(|update| ray.policy.push_front(update));
                continue;
            }
            if wires.ray(id).setting > 0 || self.spec.register.get() == 0 {
                return self.access(id, step, wires);
            }
            match self.register(step, wires) {
                Registered::Done => {
                    wires.ray(id).policy.pop_front();
                }
                Registered::Perform(step) => {
                    wires.ray(id).policy[0] = step;
                    return self.access(id, step, wires);
                }
            }
        }
        self.ray_done(id, now, wires);
    }

    fn register(&mut self, step: Step, wires: &mut Wires) -> Registered {
        let (Step::Read { store, .. } | Step::Write { store, .. } | Step::Update { store, .. }) = step else {
            return Registered::Perform(step);
        };
        let addr = address(step, &wires.layout);
        if store == Store::OccluderId {
            return Registered::Perform(step);
        }
        if !step.writes() {
            if self.read.iter().any(|&read| Some(read) == addr) {
                wires.words.work.merged_reads += 1;
                return Registered::Done;
            }
            return Registered::Perform(step);
        }
        if self.waiting.iter().any(|&other| address(other, &wires.layout) == addr) {
            wires.words.work.merged_writes += 1;
            return Registered::Done;
        }
        self.waiting.push(step);
        if self.waiting.len() <= self.spec.register.size() {
            return Registered::Done;
        }
        Registered::Perform(self.waiting.remove(0))
    }

    /// Accesses the entry of the ray's next step.
    fn access(&mut self, id: Id, step: Step, wires: &mut Wires) {
        let Some((store, index)) = step.entry() else { unreachable!("{step:?} is of no entry") };
        let element = wires.layout.entry(store, index, step.writes());
        match self.spec.place {
            Place::Own | Place::Free => self.unit.fetch(id, element, &wires.layout),
            Place::Triangle => self.leaving.push_back(id),
            Place::L2 if step.writes() && wires.ray(id).setting == 0 => self.unit.ready_with(id, element),
            Place::L2 => self.unit.fetch_bypass(id, element, &wires.layout),
        }
    }

    fn ray_done(&mut self, id: Id, now: u64, wires: &mut Wires) {
        if id < self.pool {
            return self.done.push_back(id);
        }
        self.in_work -= 1;
        wires.rays[id] = None;
        self.free_entries.push_back(id);
        self.end_left = self.end_left.map(|left| left - 1);
        self.look_at_the_end(now, wires);
    }

    /// Reports when this unit's part of the end-of-frame update is done.
    fn look_at_the_end(&mut self, now: u64, wires: &mut Wires) {
        if self.end_left == Some(0) {
            self.end_left = None;
            wires.words.ending -= 1;
            if wires.words.ending == 0 {
                wires.frame_over.put(now, ());
            }
        }
    }

    pub(super) fn queues(&self, wires: &Wires) -> String {
        format!(
            "{}, to come {}, contexts {}/{}, leaving for intersection {}, steps of the frame's end {}",
            self.unit.queues(),
            wires.retired[self.index].len(),
            self.in_work,
            self.spec.contexts,
            self.leaving.len(),
            self.end_left.unwrap_or(0)
        )
    }
}
