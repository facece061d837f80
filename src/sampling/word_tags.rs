//! The tags of the shadow-cache units' L1s. They receive the policy steps of each ray, at the end of its path
//! ([`super::path_tags`]). Machines that differ in these units alone share the paths.

use std::ops::Range;
use std::sync::Arc;

use super::covariates::{Capacity, Covariates};
use super::path_tags::{PathEnd, PathOutcome};
use super::performed::{self, Performed};
use super::requests::{Request, Requester, Requests};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::layout::{Element, Layout, Shift};
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};
use crate::machine::traffic::HostTraffic;
use crate::machine::writes::WritePolicy;
use crate::memory::cache::Access;
use crate::memory::timeless::TimelessCache;
use crate::quantity::LineAddr;
use crate::stream::{Chunk, Decision, FrameInfo, Header, Step};

/// The tags of all shadow-cache units' L1s, and the state of their covariates. Machines with a common path whose
/// `WordTags` are equal before a stream have equal ones behind it, and equal requests to their L2s.
#[derive(Debug, PartialEq)]
pub(super) struct WordTags {
    layout: Layout,
    spec: ShadowCacheSpec,
    performed: Performed,
    units: Units,
    /// Operations that a unit can begin in a cycle.
    width: u64,
    /// Determines the number of rays in flight; without the DRAM.
    capacity: Capacity,
    /// The host's own lines.
    host: Option<HostTraffic>,
}

/// The shadow-cache units.
#[derive(Debug, PartialEq)]
struct Units {
    place: Place,
    l1s: Vec<TimelessCache>,
    writes: WritePolicy,
    /// Minimum cycles between operations.
    interval: u64,
    cores: usize,
    /// Cycles of operations on entries, by owner unit.
    of_owners: Vec<u64>,
}

impl WordTags {
    /// Empty caches.
    pub(super) fn new(header: &Header, machine: &MachineSpec) -> Self {
        let line = machine.line_bytes.get();
        let unit = Kind::ShadowCache.spec(machine);
        let l1 = TimelessCache::new(unit.cache.tags(line), unit.cache.no_allocate);
        let units = Units {
            place: machine.shadow_cache.place,
            l1s: vec![l1; unit.count as usize],
            writes: unit.writes,
            interval: unit.interval,
            cores: machine.cores.size(),
            of_owners: vec![0; unit.count as usize],
        };
        Self {
            layout: Layout::new(header, machine),
            spec: performed::spec_of(machine),
            performed: Performed::new(machine, header),
            units,
            width: unit.width,
            capacity: Capacity::of_units(machine),
            host: HostTraffic::new(&machine.traffic, line),
        }
    }

    /// The addresses of the frame's arrays.
    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The contents of the L1s.
    pub(super) fn snapshot(&self) -> Arc<Vec<TimelessCache>> {
        Arc::new(self.units.l1s.clone())
    }

    /// Begins a frame: drops the lines of the dynamic part.
    pub(super) fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        let first = self.layout.dynamic_part();
        self.units.l1s.iter_mut().for_each(|cache| cache.drop_from(first));
    }

    /// The policy accesses of a chunk's rays, each at the end of its path. `outcome` has the paths' requests and
    /// ends; `shift` moves their lines to this machine's layout.
    pub(super) fn piece(&mut self, chunk: &Chunk, rays: Range<usize>, outcome: &PathOutcome, shift: Shift) -> Requests {
        let mut to =
            Requests { list: Vec::with_capacity(outcome.requests.list.len()), covariates: outcome.requests.covariates };
        let Self { layout, performed, units, .. } = self;
        let mut from = 0;
        for end in &outcome.ends {
            here(&outcome.requests.list[from..end.requests], shift, &mut to);
            from = end.requests;
            let policy = chunk.ray(end.ray).packed_policy();
            performed.of_ray(policy, layout, |step| units.perform(step, layout, end, &mut to));
        }
        here(&outcome.requests.list[from..], shift, &mut to);
        self.whole_rays(chunk, rays, &mut to.covariates);
        self.settle_owner(&mut to.covariates);
        to
    }

    /// The steps of an end of frame.
    pub(super) fn frame_end(&mut self, steps: &[u32], outcome: &PathOutcome, shift: Shift) -> Requests {
        let mut to = Requests { list: Vec::new(), covariates: outcome.requests.covariates };
        here(&outcome.requests.list, shift, &mut to);
        for step in self.performed.at_end(steps, &self.layout) {
            self.units.perform(step, &self.layout, &PathEnd::default(), &mut to);
        }
        self.settle_owner(&mut to.covariates);
        to
    }

    /// Rays in traversal units at once, from a piece's covariates ([`Capacity::in_flight`]); `None` if nothing was
    /// done.
    pub(super) fn in_flight(&self, covariates: &Covariates) -> Option<f64> {
        self.capacity.in_flight(covariates)
    }

    /// Work of rays outside steps: the host's lines, and decisions that take an operation.
    fn whole_rays(&mut self, chunk: &Chunk, rays: Range<usize>, covariates: &mut Covariates) {
        if let Some(host) = &mut self.host {
            for ray in rays.clone().map(|ray| chunk.ray(ray)).filter(|ray| !self.spec.is_answered(ray)) {
                let runs = host.ray().into_iter().chain(host.result(ray.head.kind, ray.packed_path()));
                runs.for_each(|run| covariates.dram[run.class as usize] += run.lines);
            }
        }
        if self.spec.decide.takes_an_operation(Decision::Skip) {
            let skipped = rays.filter(|&ray| chunk.head(ray).decision == Decision::Skip).count();
            covariates.operations[Kind::ShadowCache as usize] += skipped as u64 * self.units.interval;
        }
    }

    /// Sets the covariate of the busiest owner unit of a piece, in cycles.
    fn settle_owner(&mut self, covariates: &mut Covariates) {
        let of_owners = &mut self.units.of_owners;
        covariates.owner = of_owners.iter().copied().max().unwrap_or_default().div_ceil(self.width);
        of_owners.fill(0);
    }
}

impl Units {
    /// A policy step of the ray whose path ends at `end`.
    #[inline]
    fn perform(&mut self, step: Step, layout: &Layout, end: &PathEnd, to: &mut Requests) {
        let element = match step {
            // Performed by the path's units ([`super::path_tags`]).
            Step::Triangle { .. } => return,
            Step::Node(node) => layout.node(node),
            Step::List(entry) => layout.list_entry(entry),
            Step::Read { store, index } => layout.entry(store, index, false),
            Step::Write { store, index } | Step::Update { store, index } => layout.entry(store, index, true),
        };
        to.covariates.operations[Kind::ShadowCache as usize] += self.interval;
        let lines = layout.lines(&element);
        let units = self.l1s.len();
        if step.entry().is_none() {
            let of_core = units / self.cores;
            let unit = usize::from(end.core) * of_core + end.entry as usize % of_core;
            return self.access(unit, &element, lines, to);
        }
        let owner = if units == 1 { 0 } else { (lines.0.0 % units as u64) as usize };
        match self.place {
            Place::Own => {
                self.of_owners[owner] += self.interval;
                self.access(owner, &element, lines, to);
            }
            Place::L2 => {
                self.of_owners[owner] += self.interval;
                to.covariates.missed[Kind::ShadowCache as usize] += 1;
                to.add(Request { line: lines.0, core: self.core(owner), class: element.class, write: element.write });
            }
            // `Triangle` entries are accessed by the path's units; `Free` ones cost nothing.
            Place::Triangle | Place::Free => {}
        }
    }

    fn core(&self, unit: usize) -> u16 {
        if self.cores == 1 { 0 } else { (unit * self.cores / self.l1s.len()) as u16 }
    }

    fn access(&mut self, unit: usize, element: &Element, lines: (LineAddr, u64), to: &mut Requests) {
        let access = if element.write { self.writes.access(element.class, true) } else { Access::Read };
        let requester = Requester { kind: Kind::ShadowCache, core: self.core(unit), class: element.class, access };
        to.access_all(&mut self.l1s[unit], requester, lines);
    }
}

/// Adds requests of the paths, with lines moved by `shift`.
fn here(requests: &[Request], shift: Shift, to: &mut Requests) {
    to.list.extend(requests.iter().map(|it| Request { line: shift.line(it.line), ..*it }));
}

#[cfg(test)]
mod tests {
    use super::super::path_tags::PathTags;
    use super::*;
    use crate::engine::tests::num;
    use crate::engine::tests::synthetic::{SyntheticRay, frame, header, nodes};
    use crate::machine::word_traffic::{LatchedCopy, SilentUpdates};
    use crate::stream::{Effect, Item, Store};

    /// The covariates of a piece of rays with these policy steps; each ray visits one node.
    fn passed(path: &mut PathTags, words: &mut WordTags, policies: Vec<Vec<u32>>) -> Covariates {
        let ray = |policy| SyntheticRay { policy, ..SyntheticRay::primary(nodes([0])) };
        let rays: Vec<SyntheticRay> = policies.into_iter().map(ray).collect();
        let items = frame(FrameInfo::default(), &rays, &[], rays.len());
        let Some(Item::Rays(chunk)) = items.get(1) else { panic!("one chunk") };
        let outcome = path.piece(chunk, 0..chunk.len());
        let shift = path.shift_to(words.layout()).unwrap();
        words.piece(chunk, 0..chunk.len(), &outcome, shift).covariates
    }

    fn read(index: u32) -> Vec<u32> {
        vec![Step::Read { store: Store::ModeWord, index }.pack()]
    }

    fn tags(machine: &MachineSpec) -> (PathTags, WordTags) {
        (PathTags::new(&header(), machine), WordTags::new(&header(), machine))
    }

    #[test]
    fn the_owner_with_the_most_to_do_is_known_piece_by_piece() {
        let mut machine = MachineSpec::default();
        machine.shadow_cache.count = num(4);
        let words_a_line = (machine.line_bytes.get() / 4) as u32;
        let (mut path, mut words) = tags(&machine);
        // Eight words of one line, then of eight consecutive lines.
        let one: Vec<_> = (0..8).map(read).collect();
        let spread: Vec<_> = (0..8).map(|line| read(line * words_a_line)).collect();
        let both = [one.clone(), spread.clone()].concat();
        let owners = [one, spread, both].map(|policies| passed(&mut path, &mut words, policies).owner);
        assert_eq!(owners, [8, 2, 10]);
    }

    /// Where one shadow-cache unit has nearly all the work, few rays are in traversal units.
    #[test]
    fn fewer_rays_are_in_flight_where_one_unit_holds_them_up() {
        let mut machine = MachineSpec::default();
        machine.traversal.rays = num(64);
        let (mut path, mut words) = tags(&machine);
        let covariates = passed(&mut path, &mut words, vec![read(0); 4000]);
        assert_eq!(covariates.owner, 4000);
        let stay = machine.traversal.latency.get() + machine.traversal.cache.latency.get();
        let in_flight = path.limited(words.in_flight(&covariates).unwrap());
        assert_eq!(in_flight as u64, stay, "each visits one node, and one a cycle is let through");
        // Two operations a cycle double it.
        machine.shadow_cache.width = num(2);
        let (mut path, mut words) = tags(&machine);
        let covariates = passed(&mut path, &mut words, vec![read(0); 4000]);
        assert_eq!((covariates.owner, path.limited(words.in_flight(&covariates).unwrap()) as u64), (2000, 2 * stay));
    }

    /// Tags do not access what a machine does not perform.
    #[test]
    fn updates_that_are_dropped_are_no_operations() {
        let mut machine = MachineSpec::default();
        let [changes, silent] = [Effect::Changes, Effect::Silent].map(|effect| Step::pack_word_update(0, effect));
        let operations = |machine: &MachineSpec| {
            let (mut path, mut words) = tags(machine);
            let policies = vec![[read(0), vec![changes, silent]].concat(); 10];
            passed(&mut path, &mut words, policies).operations[Kind::ShadowCache as usize]
        };
        assert_eq!(operations(&machine), 30);
        machine.shadow_cache.silent = SilentUpdates::Latched;
        assert_eq!(operations(&machine), 20);
        machine.shadow_cache.place = Place::Free;
        assert_eq!(operations(&machine), 0);
    }

    /// Larger stores move the dynamic part. Paths are shared as long as its lines stay in their sets.
    #[test]
    fn a_path_is_shared_where_the_dynamic_part_lies_elsewhere() {
        let shared = |traversal: u64| {
            let mut machine = MachineSpec::default();
            machine.traversal.cache.bytes = crate::ranged::Size::new(traversal).unwrap();
            let (mut path, _) = tags(&machine);
            machine.shadow_cache.latched = LatchedCopy::Buffers;
            let (_, mut words) = tags(&machine);
            let info = FrameInfo { dynamic_nodes: 8, ..FrameInfo::default() };
            path.begin_frame(&info);
            words.begin_frame(&info);
            path.shift_to(words.layout()).map(|shift| shift.by)
        };
        assert!(shared(4096).is_some_and(|by| by > 0), "{:?}", shared(4096));
        assert_eq!(shared(1 << 20), None);
    }
}
