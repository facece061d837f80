//! The ray dispatcher: takes rays from the host, hands them over to the units, and returns their results.

use std::sync::Arc;

use super::causes::Causes;
use super::links::Links;
use super::port::Port;
use super::ray::{Owner, RayId};
use crate::engine::host::{Host, Place, Pulled};
use crate::engine::source::{FrameCounts, StreamFault, check_ray};
use crate::engine::turns::Turns;
use crate::engine::unloaded::{RayLatencies, Unloaded};
use crate::machine::MachineSpec;
use crate::machine::dispatcher::DispatcherSpec;
use crate::machine::parts::Parts;
use crate::memory::Wake;
use crate::memory::queue::{Load, Queue};
use crate::memory::ring::Ring;
use crate::stats::Cause;
use crate::stream::{Decision, Item, RayKind, Step, Totals};

/// Events of a cycle that concern other parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Events {
    /// A frame began: all caches drop their dynamic lines.
    pub frame_began: bool,
    /// The counts of a frame that is over.
    pub frame_over: Option<Box<FrameCounts>>,
    /// Number of rays done.
    pub rays_over: usize,
}

/// The state of the stream.
#[derive(Clone, Debug)]
enum Phase {
    /// Before a frame.
    Between,
    /// In a frame.
    Open,
    /// All of the frame's rays are known.
    Closing(Arc<Vec<u32>>, Totals),
    /// The end-of-frame steps are under way, or done in this cycle.
    Ending(Totals),
    /// After the last frame.
    Finished,
}

/// The dispatcher.
#[derive(Clone, Debug)]
pub(crate) struct Dispatcher {
    spec: DispatcherSpec,
    pool: usize,
    /// The host.
    host: Host,
    phase: Phase,
    /// The number of the frame.
    frame: u32,
    waiting: Queue<Place>,
    free: Ring<RayId>,
    turns: Turns,
    /// Number of rays that each core got in this cycle.
    handed_over: Vec<u64>,
    rays: u64,
    /// Lower bounds, in cycles, of the hand-over and of path steps, by kind of ray and tag of the step.
    least_dispatch: u64,
    least_by_tag: [[u64; Step::TAGS]; RayKind::ALL.len()],
    /// Latencies of rays.
    pub latencies: RayLatencies,
    /// The unit's cycles.
    pub causes: Causes,
}

impl Dispatcher {
    /// The dispatcher of `machine` at the beginning of a stream.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        let (cores, unloaded) = (machine.cores.size(), Unloaded::new(machine));
        Self {
            spec: machine.dispatcher,
            pool: machine.pool() as usize,
            host: Host::default(),
            phase: Phase::Between,
            frame: 0,
            waiting: Queue::new(cores * machine.dispatcher.in_fifo.size()),
            free: (0..machine.pool() as RayId).collect(),
            turns: Turns::new(cores, cores * machine.traversal.count.size(), machine.traversal.rays.get()),
            handed_over: vec![0; cores],
            rays: 0,
            least_dispatch: unloaded.dispatch(),
            least_by_tag: RayKind::ALL.map(|kind| unloaded.by_tag(kind)),
            latencies: RayLatencies::default(),
            causes: Causes::default(),
        }
    }

    /// Acts in cycle `now`; `next` returns the stream's items.
    pub(crate) fn tick<E: From<StreamFault>>(
        &mut self,
        now: u64,
        next: &mut impl FnMut() -> Result<Option<Item>, E>,
        links: &mut Links,
    ) -> Result<Events, E> {
        let mut events = Events::default();
        for unit in links.freed.drain(..) {
            self.turns.give_back(unit as usize);
        }
        let width = self.spec.per_cycle.get() * self.handed_over.len() as u64;
        for _ in 0..width {
            let Some(id) = links.done.take(now, &mut links.clock) else { break };
            self.take_results(id, now, links);
            events.rays_over += 1;
        }
        if let Phase::Ending(totals) = self.phase
            && std::mem::take(&mut links.frame_over)
        {
            self.phase = Phase::Between;
            let machine = std::mem::take(&mut links.replayed);
            let stores = std::mem::take(&mut links.stores);
            let counts = FrameCounts { frame: self.frame, tracer: totals, machine, stores };
            events.frame_over = Some(Box::new(counts));
        }
        events.frame_began = self.pull(next, links)?;
        let ready_at = now + self.spec.shading_cycles.get();
        events.rays_over += self.host.shade(now, ready_at, |chunk, index| links.answer(chunk, index))?;
        self.handed_over.fill(0);
        let mut busy = false;
        for _ in 0..width {
            if !self.hand_over(now, links)? {
                break;
            }
            busy = true;
        }
        for _ in 0..width {
            if !self.waiting.has_room(now) {
                break;
            }
            let Some(ray) = self.host.give() else { break };
            self.waiting.put(ray, now + 1);
            self.pull(next, links)?;
        }
        self.close(now, links);
        let idle = match (self.waiting.first(now), self.host.shading_ends()) {
            (Some(_), _) if !links.port_lets_in(now) => Cause::Memory,
            (Some(_), _) => Cause::Blocked,
            (None, None) if self.waiting.is_empty() => Cause::Starved,
            (None, _) => Cause::Pipeline,
        };
        if busy {
            self.causes.begin(now, 1);
        }
        self.causes.cycle(now, idle);
        self.wake(now, busy, links);
        Ok(events)
    }

    /// Wakes the dispatcher for the cycles in which it has something to do.
    fn wake(&self, now: u64, busy: bool, links: &mut Links) {
        // Entries put and places freed in this cycle can be used from the next cycle on.
        let put = self.waiting.last_at().is_some_and(|at| at > now);
        let more = busy && (!self.waiting.is_empty() || self.host.has_rays());
        if put || more || self.host.has_rays() && self.waiting.has_room(now + 1) || !links.done.is_empty() {
            links.clock.wake(Parts::DISPATCHER, now + 1);
        }
        if let Some(at) = self.host.shading_ends() {
            links.clock.wake(Parts::DISPATCHER, at.max(now + 1));
        }
        if let Some(built_at) = links.port.as_ref().map(Port::built_at)
            && built_at > now
        {
            links.clock.wake(Parts::DISPATCHER, built_at);
        }
    }

    /// Takes items from the stream until a primary ray can be handed out or the frame has no more. Returns whether a
    /// frame began.
    fn pull<E: From<StreamFault>>(
        &mut self,
        next: &mut impl FnMut() -> Result<Option<Item>, E>,
        links: &mut Links,
    ) -> Result<bool, E> {
        let mut began = false;
        while self.host.wants_rays() && matches!(self.phase, Phase::Between | Phase::Open) {
            match self.host.pull(next, &links.layout)? {
                Pulled::Rays => {}
                Pulled::Frame(frame) => {
                    links.begin_frame(&frame);
                    (self.phase, self.frame, began) = (Phase::Open, frame.number, true);
                }
                Pulled::End(steps, totals) => self.phase = Phase::Closing(steps, totals),
                Pulled::Nothing => self.phase = Phase::Finished,
            }
        }
        Ok(began)
    }

    /// Hands over the next ray. Returns whether there was a ray, and a place for it.
    fn hand_over(&mut self, now: u64, links: &mut Links) -> Result<bool, StreamFault> {
        let Some(which) = self.waiting.first(now) else { return Ok(false) };
        if !links.port_lets_in(now) {
            return Ok(false);
        }
        let Some(&id) = self.free.front() else { return Ok(false) };
        let skipped = self.host.decision(which) == Decision::Skip;
        let has_room = |core: usize| self.handed_over[core] < self.spec.per_cycle.get();
        let turn = if skipped { None } else { self.turns.next(has_room) };
        if !skipped && turn.is_none() {
            return Ok(false);
        }
        let source = self.host.ray(which);
        let kind = source.head.kind;
        if !self.host.is_sound(which) {
            check_ray(source, which.index, &links.layout)?;
        }
        let by_tag = &self.least_by_tag[kind as usize];
        let least: u64 = source.packed_path().iter().map(|&word| by_tag[Step::tag(word) as usize]).sum();
        let ray = &mut links.rays[id as usize];
        ray.steps.begin(source.packed_path(), source.packed_policy());
        (ray.handed_over, ray.unloaded) = (now, self.least_dispatch + least);
        (ray.kind, ray.decision) = (source.head.kind, source.head.decision);
        (ray.place, ray.attributed) = (which, source.attributed);
        ray.undecided = links.shadow_cache.decide.takes_an_operation(source.head.decision);
        (ray.evaluating, ray.operand, ray.fetched, ray.list) = (0, false, false, None);
        if links.gathering.is_there() {
            (ray.hit, ray.siblings) = self.host.siblings(which, source.head.parent);
        }
        links.leave_out(id);
        match turn {
            None => links.send_to_shadow_cache(id, now),
            Some(turn) => {
                let unit = self.turns.take(turn);
                links.rays[id as usize].owner = Owner::Traversal(unit as u32);
                self.handed_over[self.turns.core(turn)] += 1;
                links.dispatched[unit].push_back((now + self.spec.latency.get(), id));
                links.post(unit as u32, now + self.spec.latency.get());
            }
        }
        self.free.pop_front();
        self.waiting.take(now, &mut links.clock);
        if let Some(port) = &mut links.port {
            port.hand_over(now, &mut links.clock);
        }
        Ok(true)
    }

    /// The host takes the results of ray `id` in cycle `now`.
    fn take_results(&mut self, id: RayId, now: u64, links: &mut Links) {
        self.free.push_back(id);
        let Links { rays, port, clock, .. } = links;
        let ray = &rays[id as usize];
        if let Some(port) = port {
            port.take_results(ray, now, clock);
        }
        self.latencies.count(ray.kind, ray.decision, ray.done - ray.handed_over, ray.unloaded);
        links.replayed.count_ray(ray.kind, ray.decision);
        self.rays += u64::from(ray.decision != Decision::Skip);
        self.host.done(ray.place, now + self.spec.shading_cycles.get());
    }

    /// Begins the end-of-frame update when all rays of the frame are done.
    fn close(&mut self, now: u64, links: &mut Links) {
        let Phase::Closing(steps, totals) = &self.phase else { return };
        if !self.host.is_empty() || !self.waiting.is_empty() || self.in_flight() > 0 || !links.port_lets_end(now) {
            return;
        }
        if !links.begin_end(steps, now) {
            links.frame_over = true;
            links.clock.wake(Parts::DISPATCHER, now + 1);
        }
        self.phase = Phase::Ending(*totals);
    }

    /// Rays handed over whose results the host has not taken.
    pub(crate) fn in_flight(&self) -> usize {
        self.pool - self.free.len()
    }

    /// Takes all slots, so that no unit gets a ray.
    #[cfg(test)]
    pub(crate) fn take_all_slots(&mut self) {
        self.turns.take_all();
    }

    /// Whether the stream is at its end.
    pub(crate) fn is_finished(&self) -> bool {
        matches!(self.phase, Phase::Finished)
    }

    /// Number of rays done so far, without skipped rays.
    pub(crate) fn rays(&self) -> u64 {
        self.rays
    }

    /// Rays in the in FIFO.
    pub(crate) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// The load of the in FIFO.
    pub(crate) fn load(&self) -> Load {
        self.waiting.load()
    }

    /// The state of the queues, for the report of a deadlock.
    pub(crate) fn queues(&self) -> String {
        format!(
            "rays in flight {}/{}, in FIFO {}/{}, {}, free slots {}",
            self.in_flight(),
            self.pool,
            self.waiting.len(),
            self.waiting.capacity(),
            self.host.queues(),
            self.turns.free()
        )
    }
}
