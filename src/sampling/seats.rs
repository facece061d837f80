//! The resources of a ray: a pool entry, which determines the ray's units of a core (but for the traversal unit), and a
//! slot of the traversal unit whose turn it is.

use std::collections::VecDeque;

use super::others::Units;
use crate::engine::turns::Turns;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;

/// The free entries and slots.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Seats {
    /// First freed, first taken.
    entries: VecDeque<u32>,
    slots: Turns,
    /// For each entry: the core of a ray without a slot, and the index within a core of the ray's unit of each kind.
    of_entry: Vec<(u16, Units)>,
    /// Units of each kind in a core.
    of_core: Units,
}

/// The resources of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seat {
    /// The entry.
    pub entry: u32,
    /// The core.
    pub core: u16,
    /// The units.
    pub units: Units,
}

impl Seats {
    /// All of a machine's resources, free.
    pub(super) fn new(machine: &MachineSpec) -> Self {
        let cores = machine.cores.size();
        // No path access depends on the shadow-cache units: machines may differ in them.
        let of_core = |kind: Kind| match kind {
            Kind::ShadowCache => 1,
            _ => (kind.spec(machine).count / cores as u64) as u16,
        };
        let of_core = Kind::ALL.map(of_core);
        let of_entry = |entry: u64| {
            let place = |of_core: u16| (entry % u64::from(of_core)) as u16;
            ((entry % cores as u64) as u16, of_core.map(place))
        };
        let units = Kind::Traversal.spec(machine).count as usize;
        Self {
            entries: (0..machine.pool() as u32).collect(),
            slots: Turns::new(cores, units, machine.traversal.rays.get()),
            of_entry: (0..machine.pool()).map(of_entry).collect(),
            of_core,
        }
    }

    /// Number of further rays that fit.
    pub(super) fn room(&self) -> usize {
        self.entries.len().min(self.slots.free() as usize)
    }

    /// The resources of the next ray; there is room. A skipped ray gets no slot.
    pub(super) fn take(&mut self, is_skipped: bool) -> Seat {
        let entry = self.entries.pop_front().expect("fewer rays are in flight than there are entries");
        let (core, mut units) = self.of_entry[entry as usize];
        let turn =
            (!is_skipped).then(|| self.slots.next(|_| true).expect("fewer rays are in flight than there are slots"));
        let core = turn.map_or(core, |turn| self.slots.core(turn) as u16);
        for (unit, of_core) in units.iter_mut().zip(self.of_core) {
            *unit += core * of_core;
        }
        if let Some(turn) = turn {
            units[Kind::Traversal as usize] = self.slots.take(turn) as u16;
        }
        Seat { entry, core, units }
    }

    /// A ray with a slot is done.
    pub(super) fn give_back(&mut self, seat: &Seat) {
        self.slots.give_back(seat.units[Kind::Traversal as usize].into());
        self.leave(seat);
    }

    /// A ray without a slot is done.
    pub(super) fn leave(&mut self, seat: &Seat) {
        self.entries.push_back(seat.entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::num;

    #[test]
    fn a_ray_has_the_traversal_unit_whose_turn_it_is_and_others_by_its_entry() {
        let mut machine = MachineSpec::default();
        machine.dispatcher.rays = num(4);
        machine.traversal.count = num(3);
        machine.traversal.rays = num(2);
        machine.intersection.count = num(2);
        let mut seats = Seats::new(&machine);
        assert_eq!(seats.room(), 4);
        let of =
            |seat: &Seat| (seat.entry, seat.units[Kind::Traversal as usize], seat.units[Kind::Intersection as usize]);
        let taken: Vec<Seat> = (0..4).map(|_| seats.take(false)).collect();
        assert_eq!(taken.iter().map(of).collect::<Vec<_>>(), [(0, 0, 0), (1, 1, 1), (2, 2, 0), (3, 0, 1)]);
        // The first unit is full; the second has the next turn.
        seats.give_back(&taken[2]);
        let skipped = seats.take(true);
        assert_eq!(skipped.entry, 2);
        seats.leave(&skipped);
        assert_eq!(of(&seats.take(false)), (2, 1, 0));
        seats.give_back(&taken[1]);
        assert_eq!(of(&seats.take(false)), (1, 2, 1));
    }
}
