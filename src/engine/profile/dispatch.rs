//! Untimed dispatcher: the in FIFO, rays in flight; picks the next ray or end-of-frame step and its unit.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;

use super::entries::{Entries, EntryAccess};
use super::flight::Flight;
use super::port::Port;
use crate::engine::error::RunError;
use crate::engine::feed::Feed;
use crate::engine::gathering::{Gathering, HitId, Retiring};
use crate::engine::host::{Host, Place, Pulled};
use crate::engine::source::{FrameCounts, StreamFault, check_ray};
use crate::engine::turns::Turns;
use crate::machine::MachineSpec;
use crate::machine::dispatcher::DispatcherSpec;
use crate::machine::layout::Layout;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::stream::{Chunk, Decision, FrameInfo, Header, Step, Totals};

/// The dispatcher's next output.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Given {
    /// A frame begins; the layout is already that of the frame.
    Frame(FrameInfo),
    /// The ray comes to its traversal unit in the given cycle.
    Traced(u32, u64),
    /// The ray, which is not traced, comes to a shadow-cache unit in the given cycle.
    Skipped(u32, u64),
    /// The end-of-frame step comes to a shadow-cache unit in the given cycle.
    Ending(u32, u64),
}

/// Position in the stream.
#[derive(Clone, Debug)]
enum Phase {
    Between,
    Open,
    Closing(Arc<Vec<u32>>, Totals),
    /// End-of-frame steps to begin, each with whether it is an operand; the number of steps not done.
    Ending(VecDeque<(Step, bool)>, Totals, usize),
    Finished,
}

/// The dispatcher.
#[derive(Clone, Debug)]
pub(crate) struct Dispatch {
    spec: DispatcherSpec,
    words: ShadowCacheSpec,
    host: Host,
    /// The in FIFO and its number of places.
    waiting: VecDeque<Place>,
    places: usize,
    phase: Phase,
    frame: u32,
    /// The pool, then the entries for end-of-frame steps.
    pub flights: Vec<Flight>,
    pool: usize,
    free: VecDeque<u32>,
    free_entries: VecDeque<u32>,
    turns: Turns,
    cores: usize,
    /// The cycle of the last hand-over, and the number of hand-overs in it.
    last_at: u64,
    given_then: u64,
    /// The first cycles in which the host's port lets a ray be handed over, and the end-of-frame update begin.
    pub lets_in_at: u64,
    pub lets_end_at: u64,
    /// Cycles with a hand-over.
    pub busy: u64,
    /// Work performed since the frame began.
    pub replayed: Totals,
    /// The policy's stores since the frame began.
    entries: Entries,
    gathering: Gathering,
    /// Completed rays, without skipped rays.
    pub rays_done: u64,
    /// Completed rays to be reported to the feed.
    rays_over: usize,
    /// Whether a resource was freed, so that more may be handed out.
    pub freed: bool,
}

impl Dispatch {
    /// The dispatcher of `machine`, before the stream begins.
    pub(crate) fn new(machine: &MachineSpec, header: &Header) -> Self {
        let (cores, pool) = (machine.cores.size(), machine.pool() as usize);
        let entries = cores * machine.shadow_cache.contexts.size() * machine.shadow_cache.count.size();
        Self {
            spec: machine.dispatcher,
            words: machine.shadow_cache,
            host: Host::default(),
            waiting: VecDeque::new(),
            places: cores * machine.dispatcher.in_fifo.size(),
            phase: Phase::Between,
            frame: 0,
            flights: vec![Flight::IDLE; pool + entries],
            pool,
            free: (0..pool as u32).collect(),
            free_entries: (pool as u32..(pool + entries) as u32).collect(),
            turns: Turns::new(cores, cores * machine.traversal.count.size(), machine.traversal.rays.get()),
            cores,
            last_at: 0,
            given_then: 0,
            lets_in_at: 0,
            lets_end_at: 0,
            busy: 0,
            replayed: Totals::default(),
            entries: Entries::new(machine, header),
            gathering: Gathering::new(cores * machine.shadow_cache.gather.size()),
            rays_done: 0,
            rays_over: 0,
            freed: false,
        }
    }

    /// Whether a skipped ray needs an operation for its decision.
    pub(crate) fn units_decide(&self) -> bool {
        self.words.decide.takes_an_operation(Decision::Skip)
    }

    /// Entries of the pool; flights of higher numbers are end-of-frame steps.
    pub(crate) fn pool(&self) -> usize {
        self.pool
    }

    /// Rays in flight.
    pub(crate) fn in_flight(&self) -> usize {
        self.pool() - self.free.len()
    }

    /// The next output in cycle `at`, if there is one. Reads on in the stream as far as necessary.
    pub(crate) fn next(
        &mut self,
        at: u64,
        feed: &mut dyn Feed,
        layout: &mut Layout,
    ) -> Result<Option<Given>, RunError> {
        feed.rays_over(std::mem::take(&mut self.rays_over));
        loop {
            match &mut self.phase {
                Phase::Between | Phase::Open if self.host.wants_rays() => {
                    match self.host.pull(&mut || feed.next(), layout)? {
                        Pulled::Rays => {}
                        Pulled::Frame(info) => {
                            layout.begin_frame(&info);
                            (self.phase, self.frame) = (Phase::Open, info.number);
                            return Ok(Some(Given::Frame(info)));
                        }
                        Pulled::End(steps, totals) => self.phase = Phase::Closing(steps, totals),
                        Pulled::Nothing => self.phase = Phase::Finished,
                    }
                }
                _ if self.waiting.len() < self.places && self.host.has_rays() => self.waiting.extend(self.host.give()),
                Phase::Closing(steps, totals)
                    if self.host.is_empty() && self.waiting.is_empty() && self.free.len() == self.pool =>
                {
                    let (recorded, totals) = (Arc::clone(steps), *totals);
                    let counts = (&mut self.entries.work, &mut self.replayed);
                    let planned = self.entries.steps.end(&recorded, layout, counts);
                    let waiting = self.entries.drain().map(|step| (step, true));
                    let steps: VecDeque<_> = waiting.chain(planned.into_iter().map(|step| (step, false))).collect();
                    let left = steps.len();
                    self.phase = Phase::Ending(steps, totals, left);
                }
                Phase::Ending(_, totals, 0) => {
                    let machine = std::mem::take(&mut self.replayed);
                    let stores = std::mem::take(&mut self.entries.work);
                    feed.frame_over(&FrameCounts { frame: self.frame, tracer: *totals, machine, stores })?;
                    self.phase = Phase::Between;
                }
                Phase::Ending(steps, ..) => {
                    let Some(&id) = self.free_entries.front() else { return Ok(None) };
                    let Some((step, operand)) = steps.pop_front() else { return Ok(None) };
                    self.free_entries.pop_front();
                    let flight = &mut self.flights[id as usize];
                    (flight.path_end, flight.next, flight.evaluating, flight.operand) = (0, 0, 0, operand);
                    flight.steps.clear();
                    flight.steps.push(step.pack());
                    return Ok(Some(Given::Ending(id, at.max(self.lets_end_at) + 1)));
                }
                _ => return Ok(self.hand_out(at, layout)?),
            }
        }
    }

    /// Hands out the next ray, if there is one and a place for it.
    fn hand_out(&mut self, at: u64, layout: &Layout) -> Result<Option<Given>, StreamFault> {
        let Some(&place) = self.waiting.front() else { return Ok(None) };
        let Some(&id) = self.free.front() else { return Ok(None) };
        let skipped = self.host.decision(place) == Decision::Skip;
        let turn = if skipped { None } else { self.turns.next(|_| true) };
        if !skipped && turn.is_none() {
            return Ok(None);
        }
        let source = self.host.ray(place);
        if !self.host.is_sound(place) {
            check_ray(source, place.index, layout)?;
        }
        let flight = &mut self.flights[id as usize];
        flight.steps.clear();
        flight.steps.extend_from_slice(source.packed_path());
        flight.steps.extend_from_slice(source.packed_policy());
        (flight.path_end, flight.next, flight.place) = (source.packed_path().len(), 0, place);
        if self.gathering.is_there() {
            (flight.hit, flight.siblings) = self.host.siblings(place, source.head.parent);
        }
        let counts = (&mut self.entries.work, &mut self.replayed);
        self.entries.steps.leave_out(&mut flight.steps, flight.path_end, layout, counts);
        (flight.evaluating, flight.operand) = (0, false);
        (flight.kind, flight.decision, flight.attributed) = (source.head.kind, source.head.decision, source.attributed);
        let at = at.max(self.lets_in_at);
        if self.last_at < at {
            (self.last_at, self.given_then) = (at, 0);
        } else if self.given_then == self.spec.per_cycle.get() * self.cores as u64 {
            (self.last_at, self.given_then) = (self.last_at + 1, 0);
        }
        self.given_then += 1;
        self.busy += u64::from(self.given_then == 1);
        self.free.pop_front();
        self.waiting.pop_front();
        Ok(Some(match turn {
            None => Given::Skipped(id, self.last_at + 1),
            Some(turn) => {
                flight.unit = self.turns.take(turn) as u32;
                Given::Traced(id, self.last_at + self.spec.latency.get())
            }
        }))
    }

    /// Takes over from the host's port when rays and end-of-frame updates can begin.
    pub(super) fn heed(&mut self, port: &Port) {
        (self.lets_in_at, self.lets_end_at) = (port.lets_in_at(), port.lets_end_at());
    }

    /// The cycle of the last hand-over.
    pub(crate) fn handed_over_at(&self) -> u64 {
        self.last_at
    }

    /// The flight's next step has been performed.
    #[inline]
    pub(crate) fn performed(&mut self, id: u32) {
        let flight = &mut self.flights[id as usize];
        flight.next += 1;
        flight.evaluating = flight.evaluating.saturating_sub(1);
    }

    /// Result of an access to the entry of the flight's next step, at its owner `unit`.
    pub(crate) fn access(&mut self, id: u32, unit: usize, layout: &Layout) -> EntryAccess {
        self.entries.access(&mut self.flights[id as usize], (id as usize) < self.pool, unit, layout)
    }

    /// The ray has ended its path: it leaves its updates in the table of hits, or takes along the gathered updates.
    pub(crate) fn retire(&mut self, id: u32, layout: &Layout) {
        let Flight { kind, place, hit, siblings, ref mut steps, path_end, .. } = self.flights[id as usize];
        let ray = Retiring { kind, hit: HitId { chunk: place.chunk, place: hit }, siblings, steps, path_end };
        self.entries.work.gathered_writes += self.gathering.retire(ray, layout.stores());
    }

    /// The ray has left its traversal unit.
    pub(crate) fn left_slot(&mut self, id: u32) {
        self.turns.give_back(self.flights[id as usize].unit as usize);
        self.freed = true;
    }

    /// The flight ends in cycle `now`: a ray with all its steps, or an end-of-frame step.
    pub(crate) fn done(&mut self, id: u32, now: u64) {
        self.freed = true;
        self.flights[id as usize].count(&mut self.replayed);
        if id as usize >= self.pool() {
            self.free_entries.push_back(id);
            if let Phase::Ending(.., left) = &mut self.phase {
                *left -= 1;
            }
            return;
        }
        self.free.push_back(id);
        let flight = &self.flights[id as usize];
        self.replayed.count_ray(flight.kind, flight.decision);
        self.rays_done += u64::from(flight.decision != Decision::Skip);
        self.rays_over += 1;
        // One cycle in each FIFO.
        self.host.done(flight.place, now + 2 + self.spec.shading_cycles.get());
    }

    /// Takes all slots: no unit gets a ray any more.
    #[cfg(test)]
    pub(crate) fn take_all_slots(&mut self) {
        self.turns.take_all();
    }

    /// The cycle in which the next parent's shading ends.
    pub(crate) fn next_shaded(&self) -> Option<u64> {
        self.host.shading_ends()
    }

    /// Makes the children of parents shaded by cycle `now` ready, except those that are answered at once.
    pub(crate) fn shaded(&mut self, now: u64) {
        let Self { spec, host, words, entries: Entries { steps, work, .. }, replayed, .. } = self;
        let answered = |chunk: &Chunk, index: usize| {
            let ray = chunk.ray(index);
            let left = ray.packed_policy().iter().filter(|&&word| words.performs(word)).count();
            let answered = words.decide.answers(ray.head.decision, left);
            if answered {
                work.answered_rays += 1;
                ray.packed_policy().iter().for_each(|&word| steps.count_left_out(word, work, replayed));
                replayed.shadow_rays += 1;
                replayed.shadow_rays_skipped += 1;
            }
            Ok::<_, Infallible>(answered)
        };
        let Ok(answered) = host.shade(now, now + spec.shading_cycles.get(), answered);
        self.rays_over += answered;
        self.freed = true;
    }

    /// Whether the stream has ended and all work is done.
    pub(crate) fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Finished)
    }
}
