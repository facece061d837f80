//! The caches of many machines, which get the accesses of one pass in the same order.

use fixedbitset::FixedBitSet;
use rayon::prelude::*;

use super::filling::Filling;
use crate::engine::profile::Watch;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::shadow_cache::Place;
use crate::memory::cache::CacheSpec;
use crate::memory::l2::Home;
use crate::memory::replacement::Policy;
use crate::memory::tags::{Contents, TagArray};
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::Header;

const CLASSES: usize = TrafficClass::ALL.len();
/// Accesses that go through all caches at once: few enough to fit into a processor's L2.
const BLOCK: usize = 1 << 16;

/// Misses of a machine's caches by class.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Misses {
    pub(super) l1: [[f64; CLASSES]; Kind::ALL.len()],
    pub(super) l2: [f64; CLASSES],
    pub(super) end: End,
}

/// The share of [`Misses`] in end-of-frame updates, when no ray is in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct End {
    /// Steps that access caches.
    pub(super) accesses: f64,
    /// Accesses that miss or bypass the L1s.
    pub(super) l1: f64,
    pub(super) l2: f64,
}

/// An access of the pass.
#[derive(Clone, Copy, Debug)]
struct Access {
    line: LineAddr,
    class: TrafficClass,
    core: u16,
    /// The unit's number among the units of its kind in its core.
    unit: u16,
    /// The ray's pool entry.
    home: u32,
    /// Whether the access is of an end-of-frame step.
    ends: bool,
}

/// Whether a class is for entries of a policy's stores, which have owner units.
fn is_entry(class: TrafficClass) -> bool {
    matches!(class, TrafficClass::ModeWord | TrafficClass::PixelCounter | TrafficClass::OccluderId)
}

/// The properties of the L1s of a kind in a machine. Machines with equal shapes share the simulated L1s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    kind: usize,
    of_core: u64,
    contents: Contents,
    lines: u64,
    ways: u64,
    replacement: Policy,
    mshrs: usize,
    delay: u64,
}

/// The L1s of a kind of units.
#[derive(Debug)]
struct L1s {
    shape: Shape,
    /// Whether accesses are assigned to units as in the pass.
    as_in_pass: bool,
    units: Vec<Filling>,
    /// The block's accesses that missed.
    missed: FixedBitSet,
    misses: [u64; CLASSES],
    end: u64,
}

impl L1s {
    /// The unit that makes an access. Pool entries determine it (rules R2 and S2 of `docs/model`), except for traversal
    /// units. These get rays in turn; the next rays take the entries that they free.
    fn unit(&self, access: &Access, owners: bool) -> usize {
        let of_core = self.shape.of_core;
        if owners && is_entry(access.class) {
            return (access.line.0 % self.units.len() as u64) as usize;
        }
        let unit = if self.as_in_pass { access.unit.into() } else { u64::from(access.home) % of_core };
        (u64::from(access.core) * of_core + unit) as usize
    }

    fn take(&mut self, block: &Block, owners: bool) {
        self.missed.clear();
        for &at in &block.of_kind[self.shape.kind] {
            let access = &block.accesses[at as usize];
            let unit = self.unit(access, owners);
            if self.units[unit].misses(access.line, access.class) {
                self.missed.insert(at as usize);
                self.misses[access.class as usize] += u64::from(block.measures);
                self.end += u64::from(block.measures && access.ends);
            }
        }
    }
}

/// The memory below a machine's L1s.
#[derive(Debug)]
struct Below {
    /// The indices of its L1s.
    l1s: [usize; Kind::ALL.len()],
    /// L2 banks of all cores, ordered by core.
    banks: Vec<TagArray>,
    of_core: usize,
    homes: [Home; CLASSES],
    asked: FixedBitSet,
    misses: [u64; CLASSES],
    end: u64,
}

impl Below {
    fn take(&mut self, block: &Block, l1s: &[L1s]) {
        self.asked.clone_from(&block.past);
        self.l1s.iter().for_each(|&at| self.asked.union_with(&l1s[at].missed));
        for at in self.asked.ones() {
            let Access { line, class, core, ends, .. } = block.accesses[at];
            let bank = self.homes[class as usize].bank(line) + usize::from(core) * self.of_core;
            let bank = &mut self.banks[bank];
            if !bank.access(line, false) {
                bank.fill(line, class, false);
                self.misses[class as usize] += u64::from(block.measures);
                self.end += u64::from(block.measures && ends);
            }
        }
    }
}

/// Consecutive accesses.
#[derive(Debug)]
struct Block {
    accesses: Vec<Access>,
    /// Indices of the accesses by kind of units.
    of_kind: [Vec<u32>; Kind::ALL.len()],
    /// Accesses that bypass all L1s.
    past: FixedBitSet,
    measures: bool,
}

/// The caches of many machines.
#[derive(Debug)]
pub(super) struct Caches {
    block: Block,
    l1s: Vec<L1s>,
    machines: Vec<Below>,
    /// For each unit of the pass: its kind, its core, and its number among the units of its kind in its core.
    units: Vec<(usize, u16, u16)>,
    home: u32,
    /// Whether entries have owner units.
    owners: bool,
    /// Whether accesses to entries bypass all L1s.
    past: bool,
    /// Whether each frame to come is measured, the last frame first.
    frames: Vec<bool>,
    frame_ends: bool,
    /// Accesses in end-of-frame updates, and those of them that bypass all L1s.
    end: u64,
    end_past: u64,
}

/// Memory of the tags of a machine's L2s in bytes.
pub(super) fn bytes(machine: &MachineSpec) -> u64 {
    let lines = machine.l2.caches().iter().map(|(_, cache)| cache.bytes.get() / machine.line_bytes.get()).sum::<u64>();
    machine.cores.get() * lines * size_of::<LineAddr>() as u64
}

impl Caches {
    /// The empty caches of `machines`, which get the accesses of a pass of a stream on `reference`.
    pub(super) fn new(reference: &MachineSpec, header: &Header, machines: &[&MachineSpec]) -> Self {
        let cores = reference.cores.get();
        let units_of = |kind: Kind| {
            let of_core = kind.spec(reference).count / cores;
            (0..cores * of_core).map(move |unit| (kind as usize, (unit / of_core) as u16, (unit % of_core) as u16))
        };
        let mut caches = Self {
            block: Block {
                accesses: Vec::with_capacity(BLOCK),
                of_kind: Default::default(),
                past: FixedBitSet::with_capacity(BLOCK),
                measures: false,
            },
            l1s: Vec::new(),
            machines: Vec::new(),
            units: Kind::ALL.into_iter().flat_map(units_of).collect(),
            home: 0,
            owners: matches!(reference.shadow_cache.place, Place::Own | Place::Triangle),
            past: reference.shadow_cache.place == Place::L2,
            frames: header.frames.iter().rev().map(|frame| !header.warmup.contains(frame)).collect(),
            frame_ends: false,
            end: 0,
            end_past: 0,
        };
        machines.iter().for_each(|machine| caches.add(reference, machine));
        caches
    }

    fn add(&mut self, reference: &MachineSpec, machine: &MachineSpec) {
        let (line, cores) = (machine.line_bytes.get(), machine.cores.get());
        let l2 = machine.l2.caches();
        // A busy unit makes one access per cycle.
        let delay = l2.iter().map(|(_, cache)| cache.latency.get()).max().unwrap_or_default() + 2;
        let l1s = Kind::ALL.map(|kind| {
            let (spec, pass) = (kind.spec(machine), kind.spec(reference));
            let CacheSpec { contents, replacement, ref bytes, ref ways, ref mshrs, .. } = spec.cache;
            let (lines, ways, mshrs) = (bytes.get() / line, ways.get(), mshrs.size());
            let of_core = spec.count / cores;
            let shape = Shape { kind: kind as usize, of_core, contents, lines, ways, replacement, mshrs, delay };
            self.l1s.iter().position(|l1s| l1s.shape == shape).unwrap_or_else(|| {
                let unit = Filling::new(spec.cache.tags(line), delay, mshrs);
                let units = vec![unit; spec.count as usize];
                let as_in_pass = spec.count == pass.count;
                let missed = FixedBitSet::with_capacity(BLOCK);
                self.l1s.push(L1s { shape, as_in_pass, units, missed, misses: [0; CLASSES], end: 0 });
                self.l1s.len() - 1
            })
        });
        let of_core: Vec<TagArray> =
            l2.iter().flat_map(|(_, cache)| vec![cache.bank_tags(line); cache.banks.size()]).collect();
        self.machines.push(Below {
            l1s,
            banks: (0..cores).flat_map(|_| of_core.clone()).collect(),
            of_core: of_core.len(),
            homes: machine.l2.homes(),
            asked: FixedBitSet::with_capacity(BLOCK),
            misses: [0; CLASSES],
            end: 0,
        });
    }

    /// Records an access by a unit of a kind; `None` for an access that bypasses all L1s.
    fn access(&mut self, kind: Option<usize>, (core, unit): (u16, u16), line: LineAddr, class: TrafficClass) {
        let at = self.block.accesses.len();
        match kind {
            Some(kind) => self.block.of_kind[kind].push(at as u32),
            None => self.block.past.insert(at),
        }
        let ends = self.frame_ends;
        self.end += u64::from(self.block.measures && ends);
        self.end_past += u64::from(self.block.measures && ends && kind.is_none());
        self.block.accesses.push(Access { line, class, core, unit, home: self.home, ends });
        if at + 1 == BLOCK {
            self.take();
        }
    }

    /// Sends the block through all caches.
    fn take(&mut self) {
        let Self { block, l1s, machines, owners, .. } = self;
        l1s.par_iter_mut().for_each(|l1s| l1s.take(block, *owners));
        machines.par_iter_mut().for_each(|machine| machine.take(block, l1s));
        block.accesses.clear();
        block.of_kind.iter_mut().for_each(Vec::clear);
        block.past.clear();
    }

    /// The misses of each machine's caches.
    pub(super) fn finish(mut self) -> Vec<Misses> {
        self.take();
        let counted = |misses: &[u64; CLASSES]| misses.map(|count| count as f64);
        let of = |machine: &Below| Misses {
            l1: machine.l1s.map(|at| counted(&self.l1s[at].misses)),
            l2: counted(&machine.misses),
            end: End {
                accesses: self.end as f64,
                l1: (self.end_past + machine.l1s.iter().map(|&at| self.l1s[at].end).sum::<u64>()) as f64,
                l2: machine.end as f64,
            },
        };
        self.machines.iter().map(of).collect()
    }
}

impl Watch for Caches {
    fn entry(&mut self, home: usize, frame_ends: bool) {
        (self.home, self.frame_ends) = (home as u32, frame_ends);
    }

    fn l1(&mut self, unit: usize, line: LineAddr, class: TrafficClass) {
        let (kind, core, unit) = self.units[unit];
        self.access(Some(kind), (core, unit), line, class);
    }

    fn l2(&mut self, core: usize, line: LineAddr, class: TrafficClass) {
        if self.past && is_entry(class) {
            self.access(None, (core as u16, 0), line, class);
        }
    }

    fn drop_from(&mut self, first: LineAddr) {
        self.take();
        self.block.measures = self.frames.pop().unwrap_or(true);
        self.l1s.par_iter_mut().for_each(|l1s| l1s.units.iter_mut().for_each(|unit| unit.drop_from(first)));
        self.machines
            .par_iter_mut()
            .for_each(|machine| machine.banks.iter_mut().for_each(|bank| bank.drop_from(first)));
    }
}
