//! The ray dispatcher: takes rays from the stream, hands them over when they are ready, and knows when they are done.

use std::collections::VecDeque;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::MachineSpec;
use super::causes::Causes;
use super::links::{Links, Parts};
use super::ray::{Owner, RayId};
use super::source::{FrameCounts, StreamFault, check_step, parents};
use super::unloaded::{RayLatencies, Unloaded};
use crate::memory::Wake;
use crate::ranged::Within;
use crate::stats::Cause;
use crate::stream::{Chunk, Decision, Item, RayKind, Totals};

/// The dispatcher. The defaults are the T&I engine's (Nah et al. 2011, section 4: 128 rays in the input buffer, one handed over a
/// cycle); the latency is its reciprocal of 16 cycles and a box test of 8; shading is assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DispatcherSpec {
    /// Pool entries a core, shared by all: rays handed over and not done.
    pub rays: Within<1, 65_536>,
    /// Rays handed over a cycle and a core.
    pub per_cycle: Within<1, 64>,
    /// Cycles from the hand-over to the traversal unit.
    pub latency: Within<1, 10_000>,
    /// Cycles from a ray that is done to its children.
    pub shading_cycles: Within<1, 1_000_000>,
}

impl Default for DispatcherSpec {
    fn default() -> Self {
        Self {
            rays: const { Within::literal(128) },
            per_cycle: const { Within::literal(1) },
            latency: const { Within::literal(24) },
            shading_cycles: const { Within::literal(100) },
        }
    }
}

/// A ray of a chunk in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ChunkRay {
    chunk: u32,
    index: u32,
}

/// A chunk of which some rays are not done.
#[derive(Clone, Debug)]
struct ActiveChunk {
    chunk: Arc<Chunk>,
    /// Ray `i` has the children `children[first_child[i]..first_child[i + 1]]`.
    first_child: Vec<u32>,
    children: Vec<u32>,
    primaries: Vec<u32>,
    left: usize,
}

impl ActiveChunk {
    fn new(chunk: Arc<Chunk>) -> Result<Self, StreamFault> {
        let count = chunk.len();
        let parents = parents(&chunk)?;
        let mut primaries = Vec::new();
        let mut first_child = vec![0u32; count + 2];
        for (index, &parent) in parents.iter().enumerate() {
            if index as u32 == parent {
                primaries.push(parent);
            } else {
                first_child[parent as usize + 2] += 1;
            }
        }
        // Counts become beginnings, shifted by one; filling moves each beginning to its end, the next one's beginning.
        for index in 1..first_child.len() {
            first_child[index] += first_child[index - 1];
        }
        let mut children = vec![0; count - primaries.len()];
        for (index, &parent) in parents.iter().enumerate().filter(|&(index, &parent)| index as u32 != parent) {
            let place = &mut first_child[parent as usize + 1];
            children[*place as usize] = index as u32;
            *place += 1;
        }
        Ok(Self { chunk, first_child, children, primaries, left: count })
    }

    fn children(&self, index: u32) -> &[u32] {
        &self.children[self.first_child[index as usize] as usize..self.first_child[index as usize + 1] as usize]
    }
}

/// Where the dispatcher stands in the stream.
#[derive(Clone, Debug)]
enum Phase {
    /// Before a frame.
    Between,
    /// In a frame.
    Open,
    /// All of the frame's rays are known.
    Closing(Arc<Vec<u32>>, Totals),
    /// The end's steps are under way, or done in this cycle.
    Ending(Totals),
    /// After the last frame.
    Finished,
}

/// What happened in a cycle that concerns others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Events {
    /// A frame began: dynamic lines go from all caches.
    pub frame_began: bool,
    /// A frame is over.
    pub frame_over: Option<FrameCounts>,
    /// Chunks of which the last ray was done.
    pub chunks_over: usize,
}

/// The dispatcher.
#[derive(Clone, Debug)]
pub struct Dispatcher {
    spec: DispatcherSpec,
    pool: usize,
    phase: Phase,
    chunks: Vec<Option<ActiveChunk>>,
    /// The chunk whose primary rays are handed over, and how many were.
    current: Option<(u32, usize)>,
    ready: VecDeque<ChunkRay>,
    shading: VecDeque<(u64, ChunkRay)>,
    free: VecDeque<RayId>,
    free_slots: Vec<u64>,
    cores: usize,
    /// The next unit's place in turn: the first units of all cores, then the second ones, and so on.
    next_in_turn: usize,
    /// Rays that each core got in this cycle.
    handed_over: Vec<u64>,
    frame: u32,
    rays: u64,
    unloaded: Unloaded,
    /// How long rays took.
    pub latencies: RayLatencies,
    /// The unit's cycles.
    pub causes: Causes,
}

impl Dispatcher {
    /// The dispatcher of `machine` at the beginning of a stream.
    pub fn new(machine: &MachineSpec) -> Self {
        let cores = machine.cores.size();
        Self {
            spec: machine.dispatcher,
            pool: machine.pool() as usize,
            phase: Phase::Between,
            chunks: Vec::new(),
            current: None,
            ready: VecDeque::new(),
            shading: VecDeque::new(),
            free: (0..machine.pool() as RayId).collect(),
            free_slots: vec![machine.traversal.rays.get(); cores * machine.traversal.count.size()],
            cores,
            next_in_turn: 0,
            handed_over: vec![0; cores],
            frame: 0,
            rays: 0,
            unloaded: Unloaded::new(machine),
            latencies: RayLatencies::default(),
            causes: Causes::default(),
        }
    }

    /// Cycle `now`. `next` gives the stream's items.
    pub fn tick<E: From<StreamFault>>(
        &mut self,
        now: u64,
        next: &mut impl FnMut() -> Result<Option<Item>, E>,
        links: &mut Links<impl Wake>,
    ) -> Result<Events, E> {
        let mut events = Events::default();
        for unit in links.freed.drain(..) {
            self.free_slots[unit as usize] += 1;
        }
        for index in 0..links.done.len() {
            let id = links.done[index];
            events.chunks_over += usize::from(self.ray_done(id, now - 1, links));
        }
        links.done.clear();
        if let Phase::Ending(totals) = self.phase
            && std::mem::take(&mut links.frame_over)
        {
            self.phase = Phase::Between;
            let machine = std::mem::take(&mut links.replayed);
            let stores = std::mem::take(&mut links.stores);
            events.frame_over = Some(FrameCounts { frame: self.frame, tracer: totals, machine, stores });
        }
        events.frame_began = self.pull(next, links)?;
        while let Some(&(at, parent)) = self.shading.front()
            && at <= now
        {
            self.shading.pop_front();
            let Some(chunk) = &self.chunks[parent.chunk as usize] else {
                unreachable!("a chunk stays while it has rays")
            };
            self.ready.extend(chunk.children(parent.index).iter().map(|&index| ChunkRay { index, ..parent }));
        }
        let mut busy = 0;
        self.handed_over.fill(0);
        for _ in 0..self.spec.per_cycle.get() * self.cores as u64 {
            if !self.hand_over(now, links)? {
                break;
            }
            busy = 1;
            self.pull(next, links)?;
        }
        self.close(now, links);
        let more = self.candidate().is_some();
        let idle = match (more, self.shading.is_empty()) {
            (true, _) => Cause::Blocked,
            (false, false) => Cause::Pipeline,
            (false, true) => Cause::Starved,
        };
        self.causes.cycle(now, busy, idle);
        if busy > 0 && more {
            links.clock.wake(Parts::DISPATCHER, now + 1);
        }
        if let Some(&(at, _)) = self.shading.front() {
            links.clock.wake(Parts::DISPATCHER, at);
        }
        Ok(events)
    }

    /// Takes items from the stream until a primary ray can be taken, or the frame has no more; whether a frame began.
    fn pull<E: From<StreamFault>>(
        &mut self,
        next: &mut impl FnMut() -> Result<Option<Item>, E>,
        links: &mut Links<impl Wake>,
    ) -> Result<bool, E> {
        let mut began = false;
        while self.current.is_none() && matches!(self.phase, Phase::Between | Phase::Open) {
            let item = next()?;
            let found = match &item {
                None => "its end",
                Some(Item::Frame(_)) => "a frame's beginning",
                Some(Item::Rays(_)) => "rays",
                Some(Item::End { .. }) => "a frame's end",
            };
            match (&self.phase, item) {
                (Phase::Between, None) => self.phase = Phase::Finished,
                (Phase::Between, Some(Item::Frame(frame))) => {
                    links.layout.begin_frame(&frame);
                    links.drop_dynamic_lines();
                    (self.phase, self.frame, began) = (Phase::Open, frame.number, true);
                }
                (Phase::Between, _) => return Err(StreamFault::Order { found, expected: "a frame's beginning" }.into()),
                (_, Some(Item::Rays(chunk))) => self.load(chunk)?,
                (_, Some(Item::End { policy, totals })) => {
                    for &word in policy.iter() {
                        check_step(word, &links.layout)?;
                    }
                    self.phase = Phase::Closing(policy, totals);
                }
                _ => return Err(StreamFault::Order { found, expected: "rays or a frame's end" }.into()),
            }
        }
        Ok(began)
    }

    fn load(&mut self, chunk: Arc<Chunk>) -> Result<(), StreamFault> {
        if chunk.is_empty() {
            return Ok(());
        }
        let chunk = Some(ActiveChunk::new(chunk)?);
        let free = self.chunks.iter().position(Option::is_none);
        let place = free.unwrap_or(self.chunks.len());
        if free.is_some() {
            self.chunks[place] = chunk;
        } else {
            self.chunks.push(chunk);
        }
        self.current = Some((place as u32, 0));
        Ok(())
    }

    fn chunk(&self, place: u32) -> &ActiveChunk {
        self.chunks[place as usize].as_ref().expect("a chunk stays while it has rays that are not done")
    }

    /// The ray to be handed over next.
    fn candidate(&self) -> Option<ChunkRay> {
        self.ready.front().copied().or_else(|| {
            let (chunk, taken) = self.current?;
            Some(ChunkRay { chunk, index: self.chunk(chunk).primaries[taken] })
        })
    }

    /// The place in turn of the next unit with a free slot, of a core that may get another ray in this cycle.
    fn free_unit(&self) -> Option<usize> {
        let units = self.free_slots.len();
        let mut in_turn = (self.next_in_turn..units).chain(0..self.next_in_turn);
        in_turn.find(|&turn| {
            let core_has_room = self.handed_over[turn % self.cores] < self.spec.per_cycle.get();
            core_has_room && self.free_slots[self.unit(turn)] > 0
        })
    }

    /// The unit at a place in turn.
    fn unit(&self, turn: usize) -> usize {
        let a_core = self.free_slots.len() / self.cores;
        turn % self.cores * a_core + turn / self.cores
    }

    /// Hands over the next ray; whether there was one, and a place for it.
    fn hand_over(&mut self, now: u64, links: &mut Links<impl Wake>) -> Result<bool, StreamFault> {
        let Some(which) = self.candidate() else { return Ok(false) };
        let Some(&id) = self.free.front() else { return Ok(false) };
        let source = self.chunk(which.chunk).chunk.ray(which.index as usize);
        let skipped = source.head.decision == Decision::Skip;
        let turn = if skipped { None } else { self.free_unit() };
        if !skipped && turn.is_none() {
            return Ok(false);
        }
        let ray = &mut links.rays[id as usize];
        ray.steps.clear();
        ray.steps.extend_from_slice(source.packed_path());
        ray.steps.extend_from_slice(source.packed_policy());
        ray.path_end = source.packed_path().len();
        (ray.handed_over, ray.unloaded) = (now, self.unloaded.dispatch());
        for (index, &word) in ray.steps.iter().enumerate() {
            let step = check_step(word, &links.layout)?;
            if index >= ray.path_end {
                continue;
            }
            ray.unloaded += self.unloaded.step(step, source.head.kind);
            if !step.is_traversal() {
                return Err(StreamFault::Ray { index: which.index as usize, fault: "has a policy step in its path" });
            }
        }
        (ray.next, ray.kind, ray.decision) = (0, source.head.kind, source.head.decision);
        (ray.chunk, ray.index, ray.undecided) = (which.chunk, which.index, skipped);
        (ray.evaluating, ray.operand, ray.fetched, ray.list) = (0, false, false, None);
        links.take_free_entries(id);
        match turn {
            None => links.send_to_shadow_cache(id, now),
            Some(turn) => {
                let unit = self.unit(turn);
                links.rays[id as usize].owner = Owner::Traversal(unit as u32);
                self.free_slots[unit] -= 1;
                self.next_in_turn = (turn + 1) % self.free_slots.len();
                self.handed_over[turn % self.cores] += 1;
                links.dispatched[unit].push_back((now + self.spec.latency.get(), id));
                links.clock.wake(links.parts.traversal(unit as u32), now + self.spec.latency.get());
            }
        }
        self.free.pop_front();
        if self.ready.pop_front().is_none()
            && let Some((chunk, taken)) = self.current
        {
            let more = taken + 1 < self.chunk(chunk).primaries.len();
            self.current = more.then_some((chunk, taken + 1));
        }
        Ok(true)
    }

    /// Ray `id` was done in cycle `at`; whether it was the last of its chunk.
    fn ray_done(&mut self, id: RayId, at: u64, links: &mut Links<impl Wake>) -> bool {
        self.free.push_back(id);
        let ray = &links.rays[id as usize];
        self.latencies.count(ray.kind, ray.decision, at - ray.handed_over, ray.unloaded);
        let totals = &mut links.replayed;
        match (ray.kind, ray.decision) {
            (RayKind::Primary, _) => totals.primary_rays += 1,
            (RayKind::Reflection | RayKind::Refraction, _) => totals.secondary_rays += 1,
            (RayKind::Shadow, Decision::Trace) => totals.shadow_rays += 1,
            (RayKind::Shadow, Decision::DynamicOnly) => {
                totals.shadow_rays += 1;
                totals.shadow_rays_dynamic_only += 1;
            }
            (RayKind::Shadow, Decision::Skip) => {
                totals.shadow_rays += 1;
                totals.shadow_rays_skipped += 1;
            }
        }
        self.rays += u64::from(ray.decision != Decision::Skip);
        let Some(active) = &mut self.chunks[ray.chunk as usize] else {
            unreachable!("a chunk stays while it has rays")
        };
        active.left -= 1;
        if !active.children(ray.index).is_empty() {
            let parent = ChunkRay { chunk: ray.chunk, index: ray.index };
            self.shading.push_back((at + self.spec.shading_cycles.get(), parent));
        }
        let last = active.left == 0;
        if last {
            self.chunks[ray.chunk as usize] = None;
        }
        last
    }

    /// Begins the frame's end when all its rays are done.
    fn close(&mut self, now: u64, links: &mut Links<impl Wake>) {
        let quiet = self.candidate().is_none() && self.shading.is_empty() && self.in_flight() == 0;
        let Phase::Closing(steps, totals) = &self.phase else { return };
        if !quiet {
            return;
        }
        if !links.begin_end(steps, now) {
            links.frame_over = true;
            links.clock.wake(Parts::DISPATCHER, now + 1);
        }
        self.phase = Phase::Ending(*totals);
    }

    /// Rays handed over and not done.
    pub fn in_flight(&self) -> usize {
        self.pool - self.free.len()
    }

    /// No unit gets a ray any more.
    #[cfg(test)]
    pub fn take_all_slots(&mut self) {
        self.free_slots.fill(0);
    }

    /// Whether the stream is at its end.
    pub fn is_finished(&self) -> bool {
        matches!(self.phase, Phase::Finished)
    }

    /// Rays done so far, skipped ones not counted.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// The state of the queues, for the report of a deadlock.
    pub fn queues(&self) -> String {
        format!(
            "rays in flight {}/{}, ready {}, being shaded {}, free slots {}",
            self.in_flight(),
            self.pool,
            self.ready.len(),
            self.shading.len(),
            self.free_slots.iter().sum::<u64>()
        )
    }
}
