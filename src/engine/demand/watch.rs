//! Watches what caches are asked for, whatever they hold.

use super::distances::Distances;
use crate::engine::profile::Watch;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::shadow_cache::Place;
use crate::memory::reuse::Stack;
use crate::memory::tags::Contents;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::Header;

/// What caches were asked for.
pub(super) struct Asked {
    pub(super) l1: [[Distances; TrafficClass::ALL.len()]; Kind::ALL.len()],
    pub(super) core: [Distances; TrafficClass::ALL.len()],
    /// Of each unit its kind, its core and the stack of its L1.
    units: Vec<(Kind, usize, Stack)>,
    /// Stacks of a core: one a cache of the L2.
    cores: Vec<Vec<Stack>>,
    homes: [usize; TrafficClass::ALL.len()],
    /// Kinds whose L1s hold everything, so that nothing below is asked for.
    ideal: [bool; Kind::ALL.len()],
    /// Whether accesses to entries go past all L1s.
    past: bool,
    /// Of each frame to come, the last one first, whether it is measured.
    frames: Vec<bool>,
    measures: bool,
}

impl Asked {
    /// Watches `machine` on a stream.
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        let kinds = Kind::ALL.map(|kind| (kind, kind.spec(machine)));
        let cores = machine.cores.size();
        let units = kinds.iter().flat_map(|(kind, spec)| {
            let of_core = spec.count as usize / cores;
            (0..spec.count as usize).map(move |unit| (*kind, unit / of_core, Stack::default()))
        });
        Self {
            l1: Default::default(),
            core: Default::default(),
            units: units.collect(),
            cores: (0..cores).map(|_| machine.l2.caches().iter().map(|_| Stack::default()).collect()).collect(),
            homes: TrafficClass::ALL.map(|class| machine.l2.home(class)),
            ideal: kinds.map(|(_, spec)| spec.cache.contents == Contents::Ideal),
            past: machine.shadow_cache.place == Place::L2,
            frames: header.frames.iter().rev().map(|frame| !header.warmup.contains(frame)).collect(),
            measures: false,
        }
    }

    fn ask_core(&mut self, core: usize, line: LineAddr, class: TrafficClass) {
        let distance = self.cores[core][self.homes[class as usize]].touch(line.0 as u32, 0).map(|[distance]| distance);
        if self.measures {
            self.core[class as usize].count(distance);
        }
    }
}

impl Watch for Asked {
    fn l1(&mut self, unit: usize, line: LineAddr, class: TrafficClass) {
        let (kind, core, stack) = &mut self.units[unit];
        let distance = stack.touch(line.0 as u32, 0).map(|[distance]| distance);
        let (kind, core) = (*kind as usize, *core);
        if self.measures {
            self.l1[kind][class as usize].count(distance);
        }
        if !self.ideal[kind] {
            self.ask_core(core, line, class);
        }
    }

    fn l2(&mut self, core: usize, line: LineAddr, class: TrafficClass) {
        let is_entry = matches!(class, TrafficClass::ModeWord | TrafficClass::PixelCounter | TrafficClass::OccluderId);
        if self.past && is_entry {
            self.ask_core(core, line, class);
        }
    }

    fn drop_from(&mut self, first: LineAddr) {
        self.measures = self.frames.pop().unwrap_or(true);
        let stacks = self.units.iter_mut().map(|(.., stack)| stack).chain(self.cores.iter_mut().flatten());
        stacks.for_each(|stack| stack.drop_from(first.0 as u32));
    }
}
