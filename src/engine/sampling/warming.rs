//! Functional warming (Wunderlich et al. 2003, "SMARTS"): every window's accesses go through tags alone, without time, in the stream's
//! order. So the caches hold what they would when a window is replayed, and of every window is known about how much it moves.

use super::super::work::{Holder, Kind, Work};
use super::estimate::{KNOWN, Known};
use crate::machine::MachineSpec;
use crate::machine::layout::{Element, Layout};
use crate::machine::pipeline::WritePolicy;
use crate::machine::shadow_cache::Place;
use crate::memory::cache::{Access, Cache};
use crate::memory::l2::Home;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::{Decision, FrameInfo, Header, Ray, RayKind, Step};

/// All tags of a machine, and what they count. Rays go to units in turn.
#[derive(Clone, Debug)]
pub struct Warming {
    layout: Layout,
    place: Place,
    /// The L1s of each kind of units, core by core.
    l1s: [Vec<Cache>; Kind::ALL.len()],
    writes: [WritePolicy; Kind::ALL.len()],
    intervals: [u64; Kind::ALL.len()],
    /// Banks of the L2s, core by core.
    banks: Vec<Cache>,
    cores: usize,
    homes: [Home; TrafficClass::ALL.len()],
    /// Rays that came to a traversal unit, and all rays.
    traced: usize,
    rays: usize,
    /// The unit of each kind that the ray goes to.
    units: [usize; Kind::ALL.len()],
    known: Known,
}

impl Warming {
    /// Empty caches.
    pub fn new(header: &Header, machine: &MachineSpec) -> Self {
        let line = machine.line_bytes.get();
        let l1s = |kind: Kind| {
            let spec = kind.spec(machine);
            vec![spec.cache.build(line); spec.count as usize]
        };
        let cores = machine.cores.size();
        let of_core = || machine.l2.caches().into_iter();
        let banks = (0..cores).flat_map(|_| of_core()).flat_map(|(_, it)| vec![it.bank_cache(line); it.banks.size()]);
        Self {
            layout: Layout::new(header, machine),
            place: machine.shadow_cache.place,
            l1s: Kind::ALL.map(l1s),
            writes: Kind::ALL.map(|kind| kind.spec(machine).writes),
            intervals: Kind::ALL.map(|kind| kind.spec(machine).interval),
            banks: banks.collect(),
            cores,
            homes: machine.l2.homes(),
            traced: 0,
            rays: 0,
            units: [0; Kind::ALL.len()],
            known: Known::default(),
        }
    }

    /// The L1s of a kind of units.
    pub fn l1s(&self, kind: Kind) -> &[Cache] {
        &self.l1s[kind as usize]
    }

    /// The banks of the L2.
    pub fn banks(&self) -> &[Cache] {
        &self.banks
    }

    /// A frame begins.
    pub fn begin_frame(&mut self, info: &FrameInfo) {
        self.layout.begin_frame(info);
        let first = self.layout.dynamic_part();
        self.l1s.iter_mut().flatten().chain(&mut self.banks).for_each(|cache| cache.drop_from(first));
    }

    /// A piece's rays make their accesses, primary rays first, then those that follow from them: about the dispatcher's order. What is
    /// known of it.
    pub fn piece<'a>(&mut self, rays: impl Iterator<Item = Ray<'a>> + Clone) -> [f64; KNOWN] {
        self.known = Known::default();
        let is_primary = |ray: &Ray<'_>| ray.head.kind == RayKind::Primary;
        rays.clone().filter(is_primary).for_each(|ray| self.ray(ray));
        rays.filter(|ray| !is_primary(ray)).for_each(|ray| self.ray(ray));
        self.known.columns()
    }

    fn ray(&mut self, ray: Ray<'_>) {
        let skipped = ray.head.decision == Decision::Skip;
        let decides = if skipped { self.intervals[Kind::ShadowCache as usize] } else { 0 };
        self.known.operations[Kind::ShadowCache as usize] += decides;
        self.traced += usize::from(!skipped);
        self.rays += 1;
        // As the dispatcher goes round: the first units of all cores, then the second ones.
        let (core, turn) = (self.traced % self.cores, self.traced / self.cores);
        for (unit, (kind, l1s)) in self.units.iter_mut().zip(Kind::ALL.into_iter().zip(&self.l1s)) {
            let a_core = l1s.len() / self.cores;
            *unit = core * a_core + if kind == Kind::Traversal { turn } else { self.rays } % a_core;
        }
        self.steps(ray.packed_path(), Holder::Traversal, ray.head.kind);
        self.steps(ray.packed_policy(), Holder::ShadowCache, ray.head.kind);
    }

    /// Steps of a frame's end; what is known of them.
    pub fn frame_end(&mut self, steps: &[u32]) -> [f64; KNOWN] {
        self.known = Known::default();
        self.steps(steps, Holder::ShadowCache, RayKind::Primary);
        self.known.columns()
    }

    fn steps(&mut self, words: &[u32], holder: Holder, ray: RayKind) {
        for step in words.iter().filter_map(|&word| Step::unpack(word)) {
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
                    if self.place == Place::Own {
                        self.units[kind as usize] = unit;
                        self.access(kind, &first);
                    } else {
                        self.known.moved[kind as usize] += 1;
                        self.below(unit * self.cores / units, line, first.class, first.write);
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
    }

    /// An element is accessed by the ray's unit of a kind.
    fn access(&mut self, kind: Kind, element: &Element) {
        let (first, lines) = self.layout.lines(element);
        let writes = self.writes[kind as usize];
        let access = writes.access(element.class, element.write);
        for line in (first.0..first.0 + lines).map(LineAddr) {
            let unit = self.units[kind as usize];
            let (hit, victim) = self.l1s[kind as usize][unit].pass(line, element.class, access);
            if hit && access != Access::WriteThrough {
                continue;
            }
            let core = unit * self.cores / self.l1s[kind as usize].len();
            if let Some(victim) = victim {
                self.known.moved[kind as usize] += 1;
                self.below(core, victim.line, victim.class, true);
            }
            if !hit {
                self.known.moved[kind as usize] += 1;
                self.below(core, line, element.class, false);
            }
            if access == Access::WriteThrough {
                self.known.moved[kind as usize] += 1;
                self.below(core, line, element.class, true);
            }
        }
    }

    fn below(&mut self, core: usize, line: LineAddr, class: TrafficClass, write: bool) {
        let bank = core * (self.banks.len() / self.cores) + self.homes[class as usize].bank(line);
        let access = if write { Access::Write } else { Access::Read };
        let (hit, victim) = self.banks[bank].pass(line, class, access);
        self.known.dram += u64::from(!hit) + u64::from(victim.is_some());
    }
}
