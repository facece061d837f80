//! Recent numbers of rays from a cell to a light, which decide when a proof is tried. The table is small and in
//! memory; a new pair of cell and light replaces another pair in its slot.

use rustc_hash::FxHashMap;

use super::cells::Cell;
use super::probe::Probe;
use crate::quantity::LightId;
use crate::ranged::PowerOfTwo;
use crate::stream::Store;

/// Rays of a cell towards a light. In memory an entry takes 32 bits: an 8-bit count, a flag for each of the two
/// answers, a flag for a requested proof, and a 21-bit tag (the model compares the whole pair).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// Number of rays, saturating at 255.
    pub rays: u8,
    /// Whether a ray was lit.
    pub lit: bool,
    /// Whether a ray was dark.
    pub dark: bool,
    /// Whether a proof was requested.
    pub asked: bool,
}

impl Seen {
    /// Whether all rays had the same answer.
    pub(crate) fn uniform(self) -> bool {
        !(self.lit && self.dark)
    }
}

/// The table of a band; it starts empty.
pub(crate) struct RayCounts {
    bits: u32,
    /// The entry of the table's first slot in the store of mode words.
    base: u32,
    slots: FxHashMap<u32, (Cell, LightId, Seen)>,
}

impl RayCounts {
    /// An empty table of `size` slots, which lie from entry `base` on in the store of mode words.
    pub(crate) fn new(size: PowerOfTwo<2, 1_048_576>, base: u32) -> Self {
        Self { bits: size.get().trailing_zeros(), base, slots: FxHashMap::default() }
    }

    /// Counts a ray, with one memory access, and returns the slot's entry, which may be changed. Of a hit's rays to
    /// the points of an area light, only the first (`first`) is counted and accesses memory; the unit holds the entry
    /// for the others.
    pub(crate) fn count(
        &mut self,
        cell: Cell,
        light: LightId,
        dark: bool,
        first: bool,
        probe: &mut Probe<'_>,
    ) -> &mut Seen {
        let slot = self.slot(cell, light);
        if first {
            probe.update(Store::ModeWord, self.base + slot);
        }
        let entry = self.slots.entry(slot).or_insert((cell, light, Seen::default()));
        if (entry.0, entry.1) != (cell, light) {
            *entry = (cell, light, Seen::default());
        }
        let seen = &mut entry.2;
        seen.rays = seen.rays.saturating_add(first.into());
        seen.lit |= !dark;
        seen.dark |= dark;
        seen
    }

    /// Fibonacci hashing (Knuth, "The Art of Computer Programming" 3, section 6.4).
    fn slot(&self, cell: Cell, light: LightId) -> u32 {
        use crate::random::GOLDEN;
        let cell_bits = u64::from(cell.primitive.0) << 32 | u64::from(cell.place);
        let hash = (cell_bits.wrapping_mul(GOLDEN) ^ u64::from(light.0)).wrapping_mul(GOLDEN);
        (hash >> (64 - self.bits)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::PrimitiveId;

    #[test]
    fn slots_spread_and_stay_in_the_table() {
        let table = RayCounts::new(const { PowerOfTwo::literal(256) }, 1000);
        let mut used = std::collections::BTreeSet::new();
        for primitive in 0..64 {
            for light in 0..4 {
                let slot = table.slot(Cell::whole(PrimitiveId(primitive)).child(primitive % 4), LightId(light));
                assert!(slot < 256);
                used.insert(slot);
            }
        }
        // 256 pairs thrown at random would fill 1 - 1/e of the slots.
        assert!(used.len() > 140, "{}", used.len());
    }
}
