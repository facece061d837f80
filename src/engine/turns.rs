//! Which traversal unit gets the next ray: round robin over the first units of all cores, then the second units, and
//! so on. A unit without a free slot is passed over.

use super::part_set::PartSet;

/// The round robin over all traversal units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Turns {
    /// Free slots of each unit, core by core.
    free: Vec<u64>,
    /// Positions, in the order of turns, of units with a free slot.
    open: PartSet,
    cores: usize,
    /// Units per core.
    a_core: usize,
    /// The position whose turn is next.
    next: usize,
}

impl Turns {
    /// For `units` units in `cores` cores, with `slots` slots each.
    pub(crate) fn new(cores: usize, units: usize, slots: u64) -> Self {
        let mut open = PartSet::new(units);
        (0..units as u32).for_each(|turn| open.add(turn));
        Self { free: vec![slots; units], open, cores, a_core: units / cores, next: 0 }
    }

    /// The position of the next unit with a free slot in a core for which `has_room` is true.
    #[inline]
    pub(crate) fn next(&self, has_room: impl Fn(usize) -> bool) -> Option<usize> {
        let among = |mut from: usize, end: usize| {
            while let Some(turn) = self.open.next(from as u32, end as u32) {
                if has_room(self.core(turn as usize)) {
                    return Some(turn as usize);
                }
                from = turn as usize + 1;
            }
            None
        };
        among(self.next, self.free.len()).or_else(|| among(0, self.next))
    }

    /// The core of the unit at position `turn`.
    #[inline]
    pub(crate) fn core(&self, turn: usize) -> usize {
        if self.cores == 1 { 0 } else { turn % self.cores }
    }

    /// Takes a slot of the unit at position `turn`, and moves the turn past it. Returns the unit.
    #[inline]
    pub(crate) fn take(&mut self, turn: usize) -> usize {
        let unit = if self.cores == 1 { turn } else { self.core(turn) * self.a_core + turn / self.cores };
        self.free[unit] -= 1;
        if self.free[unit] == 0 {
            self.open.remove(turn as u32);
        }
        self.next = if turn + 1 < self.free.len() { turn + 1 } else { 0 };
        unit
    }

    /// A slot of a unit is free again.
    #[inline]
    pub(crate) fn give_back(&mut self, unit: usize) {
        let (cores, a_core) = (self.cores, self.a_core);
        self.free[unit] += 1;
        self.open.add(if cores == 1 { unit } else { unit % a_core * cores + unit / a_core } as u32);
    }

    /// Number of free slots of all units.
    pub(crate) fn free(&self) -> u64 {
        self.free.iter().sum()
    }

    /// Takes all slots, so that no unit gets a ray.
    #[cfg(test)]
    pub(crate) fn take_all(&mut self) {
        self.free.fill(0);
        self.open = PartSet::new(self.free.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_take_turns_core_by_core() {
        let mut turns = Turns::new(2, 4, 1);
        let mut given = Vec::new();
        while let Some(turn) = turns.next(|_| true) {
            given.push(turns.take(turn));
        }
        assert_eq!((given, turns.free()), (vec![0, 2, 1, 3], 0), "the first units of both cores, then the second ones");
        turns.give_back(3);
        turns.give_back(2);
        assert_eq!(turns.next(|_| true).map(|turn| turns.clone().take(turn)), Some(2), "the next in turn");
        assert_eq!(turns.next(|core| core == 0), None, "both free ones are of the second core");
    }
}
