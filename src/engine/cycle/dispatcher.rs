//! The dispatcher.

use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;

use super::group::Group;
use super::ray::{Id, Origin, Ray, Sender};
use super::wires::Wires;
use crate::engine::source::{FrameCounts, StreamFault, check_step, parents};
use crate::engine::unloaded::{RayLatencies, Unloaded};
use crate::machine::MachineSpec;
use crate::machine::dispatcher::DispatcherSpec;
use crate::stats::Cause;
use crate::stream::{Chunk, Decision, Item, RayKind, Step, Totals};

/// The dispatcher's position in the stream.
#[derive(Debug)]
enum Phase {
    Between,
    InFrame,
    /// The frame has no further rays in the stream.
    AllKnown {
        end: Arc<Vec<u32>>,
        totals: Totals,
    },
    AtTheEnd {
        totals: Totals,
    },
    Finished,
}

pub(super) struct Dispatcher {
    spec: DispatcherSpec,
    pool: usize,
    cores: usize,
    phase: Phase,
    frame: u32,
    primaries: VecDeque<Origin>,
    ready: VecDeque<Origin>,
    shading: VecDeque<(u64, Origin)>,
    free_entries: VecDeque<Id>,
    free_slots: Vec<u64>,
    last_in_turn: usize,
    /// Completed rays, without skipped rays.
    pub rays: u64,
    pub causes: [u64; Cause::ALL.len()],
    unloaded: Unloaded,
    pub latencies: RayLatencies,
}

/// Events of the dispatcher's cycle that concern other parts.
#[derive(Default)]
pub(super) struct HostCycle {
    pub frame_over: Option<FrameCounts>,
    pub frame_began: bool,
}

impl Dispatcher {
    pub(super) fn new(machine: &MachineSpec) -> Self {
        let units = machine.cores.size() * machine.traversal.count.size();
        Self {
            spec: machine.dispatcher,
            pool: machine.pool() as usize,
            cores: machine.cores.size(),
            phase: Phase::Between,
            frame: 0,
            primaries: VecDeque::new(),
            ready: VecDeque::new(),
            shading: VecDeque::new(),
            free_entries: (0..machine.pool() as usize).collect(),
            free_slots: vec![machine.traversal.rays.get(); units],
            last_in_turn: units - 1,
            rays: 0,
            causes: Default::default(),
            unloaded: Unloaded::new(machine),
            latencies: RayLatencies::default(),
        }
    }

    pub(super) fn tick<E: From<StreamFault>>(
        &mut self,
        now: u64,
        next: &mut impl FnMut() -> Result<Option<Item>, E>,
        wires: &mut Wires,
    ) -> Result<HostCycle, E> {
        let mut cycle = HostCycle::default();
        while let Some(unit) = wires.freed_slots.take(now) {
            self.free_slots[unit] += 1;
        }
        let width = self.spec.per_cycle.get() * self.cores as u64;
        for _ in 0..width {
            if let Some(id) = wires.out_fifo.take(now) {
                self.take_results(id, now, wires);
            }
        }
        if wires.frame_over.take(now).is_some()
            && let Phase::AtTheEnd { totals: tracer } = self.phase
        {
            let machine = std::mem::take(&mut wires.replayed);
            let stores = std::mem::take(&mut wires.words.work);
            cycle.frame_over = Some(FrameCounts { frame: self.frame, tracer, machine, stores });
            self.phase = Phase::Between;
        }
        cycle.frame_began = self.read_on(now, next, wires)?;
        while let Some((at, _)) = self.shading.front()
            && *at <= now
            && let Some((_, Origin { group, index: parent })) = self.shading.pop_front()
        {
            for &index in &group.children[parent] {
                let origin = Origin { group: Rc::clone(&group), index };
                if !answered(&origin, wires)? {
                    self.ready.push_back(origin);
                } else if !group.children[index].is_empty() {
                    self.shading.push_back((now + self.spec.shading_cycles.get(), origin));
                }
            }
        }
        let mut handed_over = 0;
        let mut to_core = vec![0; self.cores];
        while handed_over < width && self.hand_over(now, &mut to_core, wires)? {
            handed_over += 1;
        }
        for _ in 0..width {
            if !wires.in_fifo.has_room() {
                break;
            }
            let Some(origin) = self.ready.pop_front().or_else(|| self.primaries.pop_front()) else { break };
            wires.in_fifo.put(now, origin);
            self.read_on(now, next, wires)?;
        }
        self.begin_end(now, wires);
        let cause = if handed_over > 0 {
            Cause::Busy
        } else if wires.in_fifo.first(now).is_some() && !wires.port_lets_in(now) {
            Cause::Memory
        } else if wires.in_fifo.first(now).is_some() {
            Cause::Blocked
        } else if !wires.in_fifo.is_empty() || !self.shading.is_empty() {
            Cause::Pipeline
        } else {
            Cause::Starved
        };
        self.causes[cause as usize] += 1;
        Ok(cycle)
    }

    /// Reads the stream until a primary ray is known or the frame has no more; returns whether a frame began.
    fn read_on<E: From<StreamFault>>(
        &mut self,
        now: u64,
        next: &mut impl FnMut() -> Result<Option<Item>, E>,
        wires: &mut Wires,
    ) -> Result<bool, E> {
        let mut began = false;
        while self.primaries.is_empty() && matches!(self.phase, Phase::Between | Phase::InFrame) {
            let in_frame = matches!(self.phase, Phase::InFrame);
            let wrong = |found| {
                let expected = if in_frame { "rays or a frame's end" } else { "a frame's beginning" };
                Err(StreamFault::Order { found, expected }.into())
            };
            match next()? {
                None if in_frame => return wrong("its end"),
                None => self.phase = Phase::Finished,
                Some(Item::Frame(_)) if in_frame => return wrong("a frame's beginning"),
                Some(Item::Frame(frame)) => {
                    wires.layout.begin_frame(&frame);
                    if let Some(port) = &mut wires.port {
                        port.begin_frame(now, &frame, &wires.layout);
                    }
                    self.frame = frame.number;
                    self.phase = Phase::InFrame;
                    began = true;
                }
                Some(Item::Rays(_)) if !in_frame => return wrong("rays"),
                Some(Item::Rays(chunk)) => self.learn(chunk)?,
                Some(Item::End { .. }) if !in_frame => return wrong("a frame's end"),
                Some(Item::End { policy: end, totals }) => {
                    for &word in end.iter() {
                        check_step(word, &wires.layout)?;
                    }
                    self.phase = Phase::AllKnown { end, totals };
                }
            }
        }
        Ok(began)
    }

    fn learn(&mut self, chunk: Arc<Chunk>) -> Result<(), StreamFault> {
        let mut children = vec![Vec::new(); chunk.len()];
        let mut primaries = Vec::new();
        for (index, parent) in parents(&chunk)?.into_iter().enumerate() {
            if parent as usize == index {
                primaries.push(index);
            } else {
                children[parent as usize].push(index);
            }
        }
        let group = Rc::new(Group { chunk, children });
        self.primaries.extend(primaries.into_iter().map(|index| Origin { group: Rc::clone(&group), index }));
        Ok(())
    }

    /// Hands over the next ray if all it needs is free; returns whether it did. `to_core` counts the rays that each
    /// core got in this cycle.
    fn hand_over(&mut self, now: u64, to_core: &mut [u64], wires: &mut Wires) -> Result<bool, StreamFault> {
        let Some(origin) = wires.in_fifo.first(now).cloned() else { return Ok(false) };
        if !wires.port_lets_in(now) {
            return Ok(false);
        }
        let Some(&id) = self.free_entries.front() else { return Ok(false) };
        let (mut ray, left_out) = read_ray(origin, wires)?;
        let steps = ray.path.iter().map(|&step| self.unloaded.step(step, ray.kind));
        (ray.handed_over, ray.unloaded) = (now, self.unloaded.dispatch() + steps.sum::<u64>());
        if ray.decision == Decision::Skip {
            wires.rays[id] = Some(ray);
            wires.send_to_policy(now, id);
        } else {
            let units = self.free_slots.len();
            // Round robin: the first units of all cores, then the second units.
            let place = |turn: usize| (turn % self.cores, turn % self.cores * (units / self.cores) + turn / self.cores);
            let mut after_the_last = (1..=units).map(|step| (self.last_in_turn + step) % units);
            let can_take = |&turn: &usize| {
                let (core, unit) = place(turn);
                to_core[core] < self.spec.per_cycle.get() && self.free_slots[unit] > 0
            };
            let Some(turn) = after_the_last.find(can_take) else { return Ok(false) };
            let (core, unit) = place(turn);
            to_core[core] += 1;
            self.free_slots[unit] -= 1;
            self.last_in_turn = turn;
            ray.sender = Sender::Traversal(unit);
            wires.dispatched[unit].put(now, id);
            wires.rays[id] = Some(ray);
        }
        left_out.count(wires);
        self.free_entries.pop_front();
        wires.in_fifo.take(now);
        if let Some(port) = &mut wires.port {
            port.hand_over(now);
        }
        Ok(true)
    }

    /// The host takes the results of ray `id` in cycle `now`.
    fn take_results(&mut self, id: Id, now: u64, wires: &mut Wires) {
        self.free_entries.push_back(id);
        let ray = wires.rays[id].take().expect("a ray that is done was under way");
        self.latencies.count(ray.kind, ray.decision, ray.done - ray.handed_over, ray.unloaded);
        let replayed = &mut wires.replayed;
        match ray.kind {
            RayKind::Primary => replayed.primary_rays += 1,
            RayKind::Reflection | RayKind::Refraction => replayed.secondary_rays += 1,
            RayKind::Shadow => replayed.shadow_rays += 1,
        }
        match ray.decision {
            Decision::Trace => self.rays += 1,
            Decision::DynamicOnly => {
                self.rays += 1;
                replayed.shadow_rays_dynamic_only += 1;
            }
            Decision::Skip => replayed.shadow_rays_skipped += 1,
        }
        let origin = ray.origin.expect("a ray of the pool is of the stream");
        if let Some(port) = &mut wires.port {
            port.take_results(now, ray.kind, origin.group.chunk.ray(origin.index).packed_path());
        }
        if !origin.group.children[origin.index].is_empty() {
            self.shading.push_back((now + self.spec.shading_cycles.get(), origin));
        }
    }

    /// Step 5: begins the end-of-frame update.
    fn begin_end(&mut self, now: u64, wires: &mut Wires) {
        let Phase::AllKnown { end, totals } = &self.phase else { return };
        let rays_to_come = !self.primaries.is_empty() || !self.ready.is_empty() || !self.shading.is_empty();
        if rays_to_come || !wires.in_fifo.is_empty() || self.in_flight() > 0 || !wires.port_lets_end(now) {
            return;
        }
        let steps = wires.words.end(end, &wires.layout);
        wires.begin_end(now, steps);
        self.phase = Phase::AtTheEnd { totals: *totals };
    }

    fn in_flight(&self) -> usize {
        self.pool - self.free_entries.len()
    }

    pub(super) fn is_finished(&self) -> bool {
        matches!(self.phase, Phase::Finished)
    }

    pub(super) fn queues(&self, wires: &Wires) -> String {
        format!(
            "rays in flight {}/{}, in FIFO {}, ready {}, being shaded {}, free slots {:?}",
            self.in_flight(),
            self.pool,
            wires.in_fifo.len(),
            self.ready.len(),
            self.shading.len(),
            self.free_slots
        )
    }
}

/// Recorded policy steps that a ray does not perform.
struct LeftOut {
    /// Updates that are dropped.
    dropped: u64,
    /// Steps without cost.
    free: VecDeque<Step>,
    /// Entries of learned bits that the ray updates instead.
    learned: Vec<u32>,
}

impl LeftOut {
    fn count(self, wires: &mut Wires) {
        wires.words.work.dropped_writes += self.dropped;
        wires.replayed.count_policy(self.free.into_iter());
        wires.words.learned.extend(self.learned);
    }
}

/// Answers a skipped ray without remaining steps, if decisions are made at the hit; returns whether it did.
fn answered(origin: &Origin, wires: &mut Wires) -> Result<bool, StreamFault> {
    let decision = origin.group.chunk.head(origin.index).decision;
    if decision != Decision::Skip {
        return Ok(false);
    }
    let (ray, left_out) = read_ray(origin.clone(), wires)?;
    if !wires.words.spec.decide.answers(decision, ray.policy.len()) {
        return Ok(false);
    }
    left_out.count(wires);
    wires.words.work.answered_rays += 1;
    wires.replayed.shadow_rays += 1;
    wires.replayed.shadow_rays_skipped += 1;
    Ok(true)
}

/// The ray as the machine performs it, and the recorded steps that it leaves out.
fn read_ray(origin: Origin, wires: &Wires) -> Result<(Ray, LeftOut), StreamFault> {
    let source = origin.group.chunk.ray(origin.index);
    let spec = &wires.words.spec;
    let path: VecDeque<Step> =
        source.packed_path().iter().map(|&word| check_step(word, &wires.layout)).collect::<Result<_, _>>()?;
    if !path.iter().all(|step| step.is_traversal()) {
        return Err(StreamFault::Ray { index: origin.index, fault: "has a policy step in its path" });
    }
    let (mut policy, mut dropped) = (VecDeque::new(), 0);
    for &word in source.packed_policy() {
        let step = check_step(word, &wires.layout)?;
        if spec.silent.drops(word) {
            dropped += 1;
        } else {
            policy.push_back(step);
        }
    }
    let (mut policy, free) = wires.words.without_free(policy);
    let mut learned = Vec::new();
    for step in &mut policy {
        if let Some(update) = wires.layout.stores().learns(*step) {
            learned.extend(update.entry().map(|(_, index)| index));
            *step = update;
        }
    }
    let ray = Ray {
        kind: source.head.kind,
        decision: source.head.decision,
        path,
        policy,
        undecided: spec.decide.takes_an_operation(source.head.decision),
        at_edges: false,
        setting: 0,
        accessed: false,
        sender: Sender::ShadowCache(0),
        list: None,
        handed_over: 0,
        done: 0,
        unloaded: 0,
        origin: Some(origin),
    };
    Ok((ray, LeftOut { dropped, free, learned }))
}
