//! Functional warming (Wunderlich et al. 2003, "SMARTS"): all accesses go through tags alone, without time. So the
//! caches hold about what they would when a window is replayed, and of every window is known about how much it moves.
//! Here are the L1s' tags, and the order of the accesses; what they ask the L2 for goes on to [`super::l2_tags`].

use std::mem::{replace, take};
use std::ops::Range;
use std::sync::Arc;

use super::known::{Capacity, Known};
use super::l2_tags::Request;
use crate::engine::warm::L1s;
use crate::engine::work::{Holder, Work};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::layout::{Element, Layout};
use crate::machine::shadow_cache::{FrameEnd, Place, ShadowCacheSpec};
use crate::machine::traffic::HostTraffic;
use crate::machine::writes::WritePolicy;
use crate::memory::cache::Access;
use crate::memory::tags::Victim;
use crate::memory::timeless::TimelessCache;
use crate::quantity::LineAddr;
use crate::random::mix;
use crate::stats::TrafficClass;
use crate::stream::{Chunk, Decision, FrameInfo, Header, Ray, RayKind, Step};

/// The tags of all L1s, and what they count. Machines whose tags are equal before a stream have equal ones behind it,
/// and what they ask their L2s for is the same.
#[derive(Debug, PartialEq)]
pub(super) struct L1Tags {
    layout: Layout,
    place: Place,
    l1s: L1s,
    writes: [WritePolicy; Kind::ALL.len()],
    intervals: [u64; Kind::ALL.len()],
    cores: usize,
    /// Units of each kind that a core has.
    of_core: [u16; Kind::ALL.len()],
    /// What tells how many rays are in flight; the DRAM does not.
    capacity: Capacity,
    /// The host's own lines, and which skipped rays it answers.
    host: Option<HostTraffic>,
    /// What tells which rays are skipped for nothing, and what a frame's end does; other fields are the defaults.
    words: ShadowCacheSpec,
    /// Slots of all traversal units, and rays that are in them.
    slots: usize,
    in_flight: usize,
    /// Rays that came to a traversal unit.
    traced: u64,
    /// The unit of a core that the next ray goes to, of kinds that get them in turn.
    turns: [u16; Kind::ALL.len()],
    /// The unit of each kind that the ray goes to that makes its step.
    units: [u16; Kind::ALL.len()],
    known: Known,
    requests: Vec<Request>,
    /// Operations on entries that have their home at each shadow-cache unit.
    at_home: Vec<u64>,
}

/// What rays did.
#[derive(Debug)]
pub(super) struct Passed {
    /// What is known of it, but for what the L2 does.
    pub known: Known,
    /// What the L1s ask the L2 for, in order.
    pub requests: Vec<Request>,
}

/// Steps that a ray makes in its turn. One would stand for the machine's order best; eight take three quarters of the
/// time, and differ by about a hundredth in lines of the L2 (kitchen on `small`), which windows set right, and not in
/// those of the DRAM.
const BURST: usize = 8;

/// Packed steps in a line of the caches of most processors.
const WORDS_A_LINE: usize = 16;

/// A ray in flight.
struct Flight<'c> {
    /// The steps that are left.
    path: &'c [u32],
    policy: &'c [u32],
    kind: RayKind,
    /// The unit of each kind that it goes to.
    units: [u16; Kind::ALL.len()],
}

/// A line that an L1 was asked for.
#[derive(Clone, Copy)]
struct Asked {
    kind: Kind,
    unit: usize,
    line: LineAddr,
    class: TrafficClass,
    access: Access,
}

impl L1Tags {
    /// Empty caches.
    pub(super) fn new(header: &Header, machine: &MachineSpec) -> Self {
        let line = machine.line_bytes.get();
        let l1s = |kind: Kind| {
            let spec = kind.spec(machine);
            vec![TimelessCache::new(spec.cache.tags(line), spec.cache.no_allocate); spec.count as usize]
        };
        let cores = machine.cores.size();
        let ShadowCacheSpec { silent, decide, place, frame_end, .. } = machine.shadow_cache;
        let slots = machine.traversal.rays.size() * Kind::Traversal.spec(machine).count as usize;
        Self {
            layout: Layout::new(header, machine),
            place,
            l1s: Kind::ALL.map(l1s),
            writes: Kind::ALL.map(|kind| kind.spec(machine).writes),
            intervals: Kind::ALL.map(|kind| kind.spec(machine).interval),
            cores,
            of_core: Kind::ALL.map(|kind| (kind.spec(machine).count / cores as u64) as u16),
            capacity: Capacity::of_units(machine),
            host: HostTraffic::new(&machine.traffic, line),
            words: ShadowCacheSpec { silent, decide, place, frame_end, ..ShadowCacheSpec::default() },
            slots,
            in_flight: slots,
            traced: 0,
            turns: [0; Kind::ALL.len()],
            units: [0; Kind::ALL.len()],
            known: Known::default(),
            requests: Vec::new(),
            at_home: vec![0; Kind::ShadowCache.spec(machine).count as usize],
        }
    }

    /// What the L1s hold now.
    pub(super) fn snapshot(&self) -> Arc<L1s> {
        Arc::new(self.l1s.clone())
    }

    /// A frame begins.
    pub(super) fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        let first = self.layout.dynamic_part();
        self.l1s.iter_mut().flatten().for_each(|cache| cache.drop_from(first));
    }

    /// A piece's rays make their accesses, primary rays first, then those that follow from them. So many rays are in
    /// flight and make steps in turn as the piece before says, at most as many as traversal units have slots; they are
    /// all done when the next piece begins, so that what is first asked for by whom is clear.
    pub(super) fn piece(&mut self, chunk: &Chunk, rays: Range<usize>) -> Passed {
        let of = |primary: bool| {
            let is_of = move |&ray: &usize| (chunk.head(ray).kind == RayKind::Primary) == primary;
            rays.clone().filter(is_of)
        };
        // Rays come to their steps in turn: read once in order, they lie near when they are wanted.
        let words = chunk.packed_steps_of(rays.clone()).iter().step_by(WORDS_A_LINE);
        std::hint::black_box(words.fold(0, |all, word| all ^ word));
        let mut waiting = of(true).chain(of(false)).map(|ray| chunk.ray(ray));
        let mut flights: Vec<Flight<'_>> = Vec::with_capacity(self.in_flight);
        while flights.len() < self.in_flight
            && let Some(ray) = waiting.next()
        {
            flights.push(self.begin(ray));
        }
        let mut place = 0;
        while !flights.is_empty() {
            if place >= flights.len() {
                place = 0;
            }
            let flight = &mut flights[place];
            if !flight.path.is_empty() {
                let (steps, rest) = flight.path.split_at(BURST.min(flight.path.len()));
                flight.path = rest;
                self.units = flight.units;
                let kind = flight.kind;
                self.path(steps, kind);
                place += 1;
                continue;
            }
            self.units = flight.units;
            for &word in flight.policy {
                self.step(word, Holder::ShadowCache, flight.kind);
            }
            match waiting.next() {
                Some(ray) => flights[place] = self.begin(ray),
                None => drop(flights.swap_remove(place)),
            }
        }
        let passed = self.passed();
        if let Some(rays) = self.capacity.in_flight(&passed.known) {
            self.in_flight = (rays as usize).clamp(1, self.slots);
        }
        passed
    }

    /// Steps of a frame's end. Where words know their frame, they are left to first touches.
    pub(super) fn frame_end(&mut self, steps: &[u32]) -> Passed {
        let steps = if self.words.frame_end == FrameEnd::Epoch { &[] } else { steps };
        steps.iter().for_each(|&word| self.step(word, Holder::ShadowCache, RayKind::Primary));
        self.passed()
    }

    fn passed(&mut self) -> Passed {
        self.known.home = self.at_home.iter().copied().max().unwrap_or_default();
        self.at_home.fill(0);
        // The next piece will ask for about as much.
        let room = Vec::with_capacity(self.requests.len());
        Passed { known: take(&mut self.known), requests: replace(&mut self.requests, room) }
    }

    fn begin<'c>(&mut self, ray: Ray<'c>) -> Flight<'c> {
        if let Some(host) = &mut self.host
            && !self.words.is_answered(&ray)
        {
            let runs = host.ray().into_iter().chain(host.result(ray.head.kind, ray.packed_path()));
            runs.for_each(|run| self.known.dram[run.class as usize] += run.lines);
        }
        let skipped = ray.head.decision == Decision::Skip;
        let decides = if skipped { self.intervals[Kind::ShadowCache as usize] } else { 0 };
        self.known.operations[Kind::ShadowCache as usize] += decides;
        self.traced += u64::from(!skipped);
        // In turn, a traversal unit would see the same columns of the picture in every row: lines would stay in its L1
        // that the machine's, which gives rays to whom is free, does not keep.
        let drawn = mix(self.traced);
        let below = |bits: u64, end: u64| (((bits & u64::from(u32::MAX)) * end) >> 32) as u16;
        let core = below(drawn >> 32, self.cores as u64);
        for (turn, of_core) in self.turns.iter_mut().zip(self.of_core) {
            *turn = if *turn + 1 < of_core { *turn + 1 } else { 0 };
        }
        self.turns[Kind::Traversal as usize] = below(drawn, self.of_core[Kind::Traversal as usize].into());
        let units = std::array::from_fn(|kind| core * self.of_core[kind] + self.turns[kind]);
        Flight { path: ray.packed_path(), policy: ray.packed_policy(), kind: ray.head.kind, units }
    }

    /// Steps of a ray's path. Most visit nodes, and most nodes are in front of their set.
    fn path(&mut self, steps: &[u32], ray: RayKind) {
        let unit = usize::from(self.units[Kind::Traversal as usize]);
        let mut visits = 0;
        for &word in steps {
            let Some(node) = Step::node(word) else {
                self.step(word, Holder::Traversal, ray);
                continue;
            };
            visits += 1;
            let (first, lines) = self.layout.lines(&self.layout.node(node));
            if lines > 1 || !self.l1s[Kind::Traversal as usize][unit].is_in_front(first) {
                (first.0..first.0 + lines).for_each(|line| self.read_node(unit, LineAddr(line)));
            }
        }
        self.known.operations[Kind::Traversal as usize] += visits * self.intervals[Kind::Traversal as usize];
    }

    fn read_node(&mut self, unit: usize, line: LineAddr) {
        let (kind, class, access) = (Kind::Traversal, TrafficClass::Node, Access::Read);
        let (hit, victim) = self.l1s[kind as usize][unit].pass(line, class, access);
        if !hit {
            self.go_on(Asked { kind, unit, line, class, access }, hit, victim);
        }
    }

    fn step(&mut self, word: u32, holder: Holder, ray: RayKind) {
        let step = Step::unpack(word).expect("packed steps are valid");
        let Work { kind, first, second, .. } = Work::of(step, holder, ray, &self.layout);
        self.known.operations[kind as usize] += (1 + u64::from(second.is_some())) * self.intervals[kind as usize];
        match (step.entry(), self.place) {
            (Some(_), Place::Free) => {}
            (Some(_), Place::Triangle) => self.access(Kind::Intersection, &first),
            (Some(_), Place::L2 | Place::Own) => {
                // The home of an entry.
                let (line, _) = self.layout.lines(&first);
                let units = self.l1s[kind as usize].len();
                let unit = (line.0 % units as u64) as usize;
                self.at_home[unit] += self.intervals[kind as usize];
                if self.place == Place::Own {
                    self.units[kind as usize] = unit as u16;
                    self.access(kind, &first);
                } else {
                    self.known.missed[kind as usize] += 1;
                    self.known.moved[first.class as usize] += 1;
                    self.ask(unit * self.cores / units, line, first.class, first.write);
                }
            }
            (None, _) => {
                self.access(kind, &first);
                if let Some(second) = &second {
                    self.access(kind, second);
                }
            }
        }
    }

    /// An element is accessed by the ray's unit of a kind.
    #[inline(always)]
    fn access(&mut self, kind: Kind, element: &Element) {
        let (first, lines) = self.layout.lines(element);
        let access = match element.write {
            false => Access::Read,
            true => self.writes[kind as usize].access(element.class, true),
        };
        let unit = usize::from(self.units[kind as usize]);
        for line in (first.0..first.0 + lines).map(LineAddr) {
            let l1 = &mut self.l1s[kind as usize][unit];
            if access != Access::Read || !l1.is_in_front(line) {
                let (hit, victim) = l1.pass(line, element.class, access);
                if !hit || access == Access::WriteThrough {
                    self.go_on(Asked { kind, unit, line, class: element.class, access }, hit, victim);
                }
            }
        }
    }

    /// What an L1 has not, or does not keep, goes on below.
    fn go_on(&mut self, asked: Asked, hit: bool, victim: Option<Victim>) {
        let Asked { kind, unit, line, class, access } = asked;
        let core = unit * self.cores / self.l1s[kind as usize].len();
        if let Some(victim) = victim {
            self.known.moved[victim.class as usize] += 1;
            self.ask(core, victim.line, victim.class, true);
        }
        if !hit {
            self.known.missed[kind as usize] += 1;
            self.known.moved[class as usize] += 1;
            self.ask(core, line, class, false);
        }
        if access == Access::WriteThrough {
            self.known.moved[class as usize] += 1;
            self.ask(core, line, class, true);
        }
    }

    fn ask(&mut self, core: usize, line: LineAddr, class: TrafficClass, write: bool) {
        self.requests.push(Request { line, core: core as u16, class, write });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::synthetic::{SyntheticRay, frame, header, nodes};
    use crate::stream::{Item, Store};

    /// What a piece of rays that read these words do; each visits a node.
    fn passed(tags: &mut L1Tags, words: &[u32]) -> Passed {
        let read = |&index: &u32| Step::Read { store: Store::ModeWord, index };
        let ray = |word| SyntheticRay::primary(nodes([0])).with_policy(vec![read(word)]);
        let rays: Vec<SyntheticRay> = words.iter().map(ray).collect();
        let items = frame(FrameInfo::default(), &rays, &[], rays.len());
        let Some(Item::Rays(chunk)) = items.get(1) else { panic!("one chunk") };
        tags.piece(chunk, 0..chunk.len())
    }

    #[test]
    fn the_home_with_the_most_to_do_is_known_piece_by_piece() {
        let mut machine = MachineSpec::default();
        machine.shadow_cache.count = crate::ranged::Within::new(4).unwrap();
        let words_a_line = (machine.line_bytes.get() / 4) as u32;
        let mut tags = L1Tags::new(&header(), &machine);
        // Eight words of one line, then of eight lines, which follow one another.
        let one: Vec<u32> = (0..8).collect();
        let spread: Vec<u32> = (0..8).map(|line| line * words_a_line).collect();
        let both = [one.clone(), spread.clone()].concat();
        let homes = [&one, &spread, &both].map(|words| passed(&mut tags, words).known.home);
        assert_eq!(homes, [8, 2, 10]);
    }

    /// Where one shadow-cache unit has nearly all of the work, few rays are in traversal units.
    #[test]
    fn fewer_rays_are_in_flight_where_one_unit_holds_them_up() {
        let mut machine = MachineSpec::default();
        machine.traversal.rays = crate::ranged::Within::new(64).unwrap();
        let mut tags = L1Tags::new(&header(), &machine);
        assert_eq!(tags.in_flight, tags.slots);
        let Passed { known, .. } = passed(&mut tags, &[0; 4000]);
        assert_eq!(known.home, 4000);
        let stay = machine.traversal.latency.get() + machine.traversal.cache.latency.get();
        assert_eq!(tags.in_flight as u64, stay, "each visits one node, and one a cycle is let through");
    }
}
