//! The ids of a machine's parts.

use super::spec::MachineSpec;
use crate::memory::PartId;

/// The number of parts of each kind. Ids follow the order of these fields after the dispatcher (id 0): this is the
/// order of action in a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts {
    /// Cores. Each has an equal share of the units and banks; the first units belong to the first core.
    pub cores: u32,
    /// Traversal units.
    pub traversal: u32,
    /// List units.
    pub list: u32,
    /// Intersection units.
    pub intersection: u32,
    /// Division units.
    pub division: u32,
    /// Shadow-cache units.
    pub shadow_cache: u32,
    /// Banks of the L2s.
    pub banks: u32,
    /// Ports of the host to the DRAM: 1, or 0 if the host has no traffic with the DRAM.
    pub ports: u32,
    /// Channels of the DRAM.
    pub channels: u32,
}

impl Parts {
    /// The parts of a machine.
    pub(crate) fn new(spec: &MachineSpec) -> Self {
        let all = |a_core: u64| (spec.cores.get() * a_core) as u32;
        Self {
            cores: all(1),
            traversal: all(spec.traversal.count.get()),
            list: all(spec.list.count.get()),
            intersection: all(spec.intersection.count.get()),
            division: all(spec.division.count.get()),
            shadow_cache: all(spec.shadow_cache.count.get()),
            banks: all(spec.l2.banks()),
            ports: u32::from(spec.traffic.is_on()),
            channels: spec.dram.channels.get() as u32,
        }
    }

    /// The dispatcher.
    pub(crate) const DISPATCHER: PartId = PartId(0);

    /// Traversal unit `index`.
    pub(crate) fn traversal(&self, index: u32) -> PartId {
        PartId(1 + index)
    }

    /// List unit `index`.
    pub(crate) fn list(&self, index: u32) -> PartId {
        PartId(self.traversal(self.traversal).0 + index)
    }

    /// Intersection unit `index`.
    pub(crate) fn intersection(&self, index: u32) -> PartId {
        PartId(self.list(self.list).0 + index)
    }

    /// Division unit `index`.
    pub(crate) fn division(&self, index: u32) -> PartId {
        PartId(self.intersection(self.intersection).0 + index)
    }

    /// Shadow-cache unit `index`.
    pub(crate) fn shadow_cache(&self, index: u32) -> PartId {
        PartId(self.division(self.division).0 + index)
    }

    /// Bank `index` of the L2.
    pub(crate) fn bank(&self, index: u32) -> PartId {
        PartId(self.shadow_cache(self.shadow_cache).0 + index)
    }

    /// The host's port to the DRAM.
    pub(crate) fn port(&self) -> PartId {
        self.bank(self.banks)
    }

    /// Channel `index` of the DRAM.
    pub(crate) fn channel(&self, index: u32) -> PartId {
        PartId(self.port().0 + self.ports + index)
    }

    /// The core of a unit or a bank.
    pub(crate) fn core(&self, part: PartId) -> u32 {
        let kinds = [
            (self.traversal(0), self.traversal),
            (self.list(0), self.list),
            (self.intersection(0), self.intersection),
            (self.division(0), self.division),
            (self.shadow_cache(0), self.shadow_cache),
            (self.bank(0), self.banks),
        ];
        let (first, count) = kinds.into_iter().rfind(|(first, _)| part.0 >= first.0).expect("the part is in a core");
        (part.0 - first.0) / (count / self.cores)
    }

    /// The sort key of a list, intersection or division unit in cycle `now`: a unit of its kind with a lower key acts
    /// before it.
    #[inline]
    pub(crate) fn turn(&self, part: PartId, now: u64) -> u32 {
        let kinds =
            [(self.list(0), self.list), (self.intersection(0), self.intersection), (self.division(0), self.division)];
        let (first, count) = kinds.into_iter().rfind(|(first, _)| part >= *first).unwrap_or((part, 1));
        let acts_first = (now % u64::from(count)) as u32;
        let place = part.0 - first.0;
        first.0 + if place < acts_first { place + count } else { place } - acts_first
    }

    /// The intersection unit with index `number`, modulo the units of a core, in `core`.
    pub(crate) fn intersection_of(&self, core: u32, number: u64) -> u32 {
        self.choose(self.intersection, core, number)
    }

    /// The unit with index `number`, modulo the units of a core, in `core`; the machine has `units` units of this kind.
    #[inline]
    pub(crate) fn choose(&self, units: u32, core: u32, number: u64) -> u32 {
        let a_core = units / self.cores;
        core * a_core + (number % u64::from(a_core)) as u32
    }

    /// The number of parts.
    pub(crate) fn count(&self) -> usize {
        self.channel(self.channels).0 as usize
    }
}
