//! Functional warming (Wunderlich et al. 2003, "SMARTS"): all accesses go through tags alone, without time. The tags
//! give the approximate cache contents before a window, and the covariates of every window.
//!
//! This module has the L1 tags on the rays' paths, and the order of accesses. The tags of the shadow-cache units follow
//! in [`super::word_tags`], those of the L2s in [`super::l2_tags`].

use std::mem::{replace, take};
use std::ops::Range;
use std::sync::Arc;

use super::others::{KINDS, Others, Units, reader};
use super::performed::Performed;
use super::requests::{Requester, Requests};
use super::seats::{Seat, Seats};
use super::waiting::Waiting;
use crate::engine::warm::L1s;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::layout::{Layout, Shift};
use crate::machine::shadow_cache::Place;
use crate::machine::writes::WritePolicy;
use crate::memory::timeless::TimelessCache;
use crate::quantity::{LineAddr, NodeId};
use crate::stats::TrafficClass;
use crate::stream::{Chunk, Decision, FrameInfo, Header, Step};

/// The tags of all units' L1s except the shadow-cache units'.
#[derive(Clone, Debug)]
pub(super) struct PathTags {
    layout: Layout,
    /// Empty for the shadow-cache units.
    l1s: L1s,
    intervals: [u64; KINDS],
    cores: usize,
    seats: Seats,
    /// Rays in flight, and their maximum.
    in_flight: usize,
    room: usize,
    entries: Option<Entries>,
    /// Whether the L1s of intersection units allocate on triangle reads.
    keeps_triangles: bool,
    /// Operations of each kind of units since the last [`PathOutcome`].
    operations: [u64; KINDS],
    outcome: PathOutcome,
}

/// Policy entries in triangle records, which intersection units access (`place: Triangle`).
#[derive(Clone, Debug, PartialEq)]
struct Entries {
    performed: Performed,
    writes: WritePolicy,
    /// A buffer for the policy steps of a ray.
    steps: Vec<Step>,
}

/// What rays did up to the ends of their paths.
#[derive(Clone, Debug, Default)]
pub(super) struct PathOutcome {
    /// Requests of the L1s to the L2, in order.
    pub requests: Requests,
    /// Path ends of the rays that have policy steps, in order.
    pub ends: Vec<PathEnd>,
}

/// The end of a ray's path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathEnd {
    /// Number of requests before it.
    pub requests: usize,
    /// The ray's index in its chunk.
    pub ray: usize,
    /// Its core.
    pub core: u16,
    /// Its entry of the pool.
    pub entry: u32,
}

/// Maximum steps of a ray's turn. A turn ends early when the ray goes to another unit or misses in the L1. Other rays
/// then catch up, and are near this ray when its line arrives, as in the machine. Without early ends, windows predict
/// L2 bytes up to two fifths worse (kitchen on `tni_engine`).
const MOST_STEPS: usize = 16;

/// Packed steps in a cache line of most host processors.
const WORDS_A_LINE: usize = 16;

/// A ray in flight.
struct Flight<'c> {
    /// Path steps that are left.
    path: &'c [u32],
    policy: &'c [u32],
    /// The ray's index in its chunk.
    ray: usize,
    seat: Seat,
}

impl PathTags {
    /// Empty caches.
    pub(super) fn new(header: &Header, machine: &MachineSpec) -> Self {
        let line = machine.line_bytes.get();
        let l1s = |kind: Kind| {
            let spec = kind.spec(machine);
            let count = if kind == Kind::ShadowCache { 0 } else { spec.count as usize };
            vec![TimelessCache::new(spec.cache.tags(line), spec.cache.no_allocate); count]
        };
        let seats = Seats::new(machine);
        // No path access depends on the shadow-cache units: machines may differ in them.
        let interval = |kind: Kind| if kind == Kind::ShadowCache { 1 } else { kind.spec(machine).interval };
        let entries = || Entries {
            performed: Performed::new(machine, header),
            writes: machine.triangle_writes(),
            steps: Vec::new(),
        };
        Self {
            layout: Layout::new(header, machine),
            l1s: Kind::ALL.map(l1s),
            intervals: Kind::ALL.map(interval),
            cores: machine.cores.size(),
            in_flight: seats.room(),
            room: seats.room(),
            seats,
            entries: (machine.shadow_cache.place == Place::Triangle).then(entries),
            keeps_triangles: machine.intersection.cache.no_allocate.keeps(TrafficClass::Triangle, false),
            operations: [0; KINDS],
            outcome: PathOutcome::default(),
        }
    }

    /// Whether both have equal state, so that equal input keeps them equal.
    pub(super) fn is_as(&self, other: &Self) -> bool {
        let tags = |it: &Self| (it.in_flight, it.cores, it.intervals);
        tags(self) == tags(other)
            && self.seats == other.seats
            && self.l1s == other.l1s
            && self.entries == other.entries
            && self.shift_to(&other.layout).is_some()
    }

    /// The shift of the path's lines in `layout`, if only the dynamic part is moved, by lines of the same sets;
    /// otherwise `None`.
    pub(super) fn shift_to(&self, layout: &Layout) -> Option<Shift> {
        let shift = self.layout.shift_to(layout)?;
        let same_sets = self.l1s.iter().flatten().all(|l1| shift.by.unsigned_abs().is_multiple_of(l1.tags().span()));
        let same_entries = self.entries.is_none() || self.layout == *layout;
        (same_sets && same_entries).then_some(shift)
    }

    /// A copy with this number of rays in flight and with `layout`.
    pub(super) fn with(&self, in_flight: usize, layout: &Layout) -> Self {
        Self { in_flight, layout: layout.clone(), ..self.clone() }
    }

    /// Rays in flight.
    pub(super) fn in_flight(&self) -> usize {
        self.in_flight
    }

    /// Sets the number of rays in flight.
    pub(super) fn set_in_flight(&mut self, rays: usize) {
        self.in_flight = rays;
    }

    /// The number of rays in flight, limited to the range from 1 to the machine's room.
    pub(super) fn limited(&self, in_flight: f64) -> usize {
        (in_flight as usize).clamp(1, self.room)
    }

    /// The contents of the L1s, with lines shifted.
    pub(super) fn snapshot(&self, shift: Shift) -> Arc<L1s> {
        let l1s = |kind: &Vec<TimelessCache>| kind.iter().map(|l1| l1.renamed(|line| shift.line(line))).collect();
        Arc::new(if shift.by == 0 { self.l1s.clone() } else { self.l1s.each_ref().map(l1s) })
    }

    /// Begins a frame: drops the lines of the dynamic part.
    pub(super) fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        let first = self.layout.dynamic_part();
        self.l1s.iter_mut().flatten().for_each(|cache| cache.drop_from(first));
    }

    /// The accesses of a piece's rays. The number of rays in flight, which take turns, follows from the piece before.
    /// All are done when the next piece begins, so each first access belongs to one piece.
    pub(super) fn piece(&mut self, chunk: &Chunk, rays: Range<usize>) -> PathOutcome {
        // Rays take turns, so their steps are read out of order: one read in order brings them into the host's cache.
        let words = chunk.packed_steps_of(rays.clone()).iter().step_by(WORDS_A_LINE);
        std::hint::black_box(words.fold(0, |all, word| all ^ word));
        let mut waiting = Waiting::new(chunk, rays);
        let mut flights: Vec<Flight<'_>> = Vec::with_capacity(self.in_flight);
        let mut place = 0;
        self.fill(&mut flights, &mut waiting, chunk);
        while !flights.is_empty() {
            if place >= flights.len() {
                place = 0;
            }
            let flight = &mut flights[place];
            if !flight.path.is_empty() {
                flight.path = self.path(flight.path, &flight.seat);
                place += 1;
                continue;
            }
            self.end(flight);
            self.seats.give_back(&flight.seat);
            waiting.done(flight.ray);
            match self.next(&mut waiting, chunk) {
                Some(next) => *flight = next,
                None => drop(flights.swap_remove(place)),
            }
            // A ray may have several children.
            self.fill(&mut flights, &mut waiting, chunk);
        }
        self.outcome()
    }

    /// Starts waiting rays until the number in flight is reached.
    fn fill<'c>(&mut self, flights: &mut Vec<Flight<'c>>, waiting: &mut Waiting, chunk: &'c Chunk) {
        while flights.len() < self.in_flight
            && let Some(flight) = self.next(waiting, chunk)
        {
            flights.push(flight);
        }
    }

    /// The part of an end of frame that uses the paths' L1s: triangle tests, and entries in triangle records.
    pub(super) fn frame_end(&mut self, steps: &[u32]) -> PathOutcome {
        self.tests(steps, 0, [0; KINDS]);
        if let Some(Entries { performed, .. }) = &mut self.entries {
            let performed = performed.at_end(steps, &self.layout);
            performed.into_iter().for_each(|step| self.entry(step));
        }
        self.outcome()
    }

    fn outcome(&mut self) -> PathOutcome {
        self.outcome.requests.covariates.operations =
            std::array::from_fn(|kind| self.operations[kind] * self.intervals[kind]);
        self.operations = [0; KINDS];
        // The next piece needs about the same capacity.
        let mut room = PathOutcome::default();
        room.requests.list.reserve(self.outcome.requests.list.len());
        room.ends.reserve(self.outcome.ends.len());
        replace(&mut self.outcome, room)
    }

    /// The next ray that enters a traversal unit. Skipped rays before it begin and end here.
    fn next<'c>(&mut self, waiting: &mut Waiting, chunk: &'c Chunk) -> Option<Flight<'c>> {
        loop {
            let place = waiting.next()?;
            let ray = chunk.ray(place);
            let is_skipped = ray.head.decision == Decision::Skip;
            let seat = self.seats.take(is_skipped);
            self.operations[Kind::Traversal as usize] += ray.packed_path().len() as u64;
            let flight = Flight { path: ray.packed_path(), policy: ray.packed_policy(), ray: place, seat };
            if !is_skipped {
                return Some(flight);
            }
            self.end(&flight);
            self.seats.leave(&seat);
            waiting.done(place);
        }
    }

    /// Ends a ray's path: records its end and performs the policy steps of intersection units.
    fn end(&mut self, flight: &Flight<'_>) {
        let &Flight { policy, ray, seat: Seat { entry, core, units }, .. } = flight;
        if policy.is_empty() {
            return;
        }
        self.outcome.ends.push(PathEnd { requests: self.outcome.requests.list.len(), ray, core, entry });
        self.tests(policy, core, units);
        if let Some(entries) = &mut self.entries {
            let mut steps = take(&mut entries.steps);
            entries.performed.of_ray(policy, &self.layout, |step| steps.push(step));
            steps.drain(..).for_each(|step| self.entry(step));
            self.entries.iter_mut().for_each(|entries| entries.steps = take(&mut steps));
        }
    }

    /// The triangle tests among policy steps.
    fn tests(&mut self, policy: &[u32], core: u16, units: Units) {
        let (_, mut by) = self.of_ray(core, units);
        for step in Step::unpack_all(policy) {
            if let Step::Triangle { slot, stop } = step {
                by.test(slot, stop);
            }
        }
    }

    /// A ray's turn; returns the rest of its path.
    fn path<'c>(&mut self, path: &'c [u32], seat: &Seat) -> &'c [u32] {
        match self.layout.node_lines().copied() {
            Some(lines) => self.walk(path, seat, |_, node| (lines.of(node), 1)),
            None => self.walk(path, seat, |layout, node| layout.lines(&layout.node(node))),
        }
    }

    /// Steps of a ray's path, most of which visit nodes: `lines` gives the lines of a node.
    #[inline(always)]
    fn walk<'c>(
        &mut self,
        path: &'c [u32],
        seat: &Seat,
        lines: impl Fn(&Layout, NodeId) -> (LineAddr, u64),
    ) -> &'c [u32] {
        let visitor = reader(Kind::Traversal, seat.core, TrafficClass::Node);
        let (l1, mut by) = self.of_ray(seat.core, seat.units);
        let (turn, later) = path.split_at(path.len().min(MOST_STEPS));
        let mut steps = turn.iter();
        while let Some(&word) = steps.next() {
            let is_over = match Step::node(word) {
                Some(node) => by.requests.access_all(l1, visitor, lines(by.layout, node)),
                None => {
                    by.step(word);
                    true
                }
            };
            if is_over {
                return &path[turn.len() - steps.len()..];
            }
        }
        later
    }

    /// The L1 of the ray's traversal unit, and the other units.
    #[inline]
    fn of_ray(&mut self, core: u16, units: Units) -> (&mut TimelessCache, Others<'_>) {
        let Self { layout, l1s, operations, keeps_triangles, outcome, .. } = self;
        let [traversal, lists, intersection, _] = l1s;
        let (keeps_triangles, requests) = (*keeps_triangles, &mut outcome.requests);
        let others = Others { layout, lists, intersection, units, operations, keeps_triangles, core, requests };
        (&mut traversal[usize::from(units[Kind::Traversal as usize])], others)
    }

    /// A step on an entry in a triangle record, by the entry's owner, an intersection unit.
    fn entry(&mut self, step: Step) {
        let (Some((store, index)), Some(Entries { writes, .. })) = (step.entry(), &self.entries) else { return };
        let kind = Kind::Intersection as usize;
        let element = self.layout.entry(store, index, !matches!(step, Step::Read { .. }));
        let access = writes.access(element.class, element.write);
        let (line, _) = self.layout.lines(&element);
        let count = self.l1s[kind].len();
        let unit = (line.0 % count as u64) as usize;
        let core = (unit * self.cores / count) as u16;
        let requester = Requester { kind: Kind::Intersection, core, class: element.class, access };
        let Self { layout, l1s, operations, outcome: PathOutcome { requests, .. }, .. } = self;
        operations[kind] += 1;
        requests.access_all(&mut l1s[kind][unit], requester, layout.lines(&element));
    }
}
