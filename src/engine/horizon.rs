//! A bitmap that tells which of the next cycles hold something: one bit per cycle, as a ring. Timing wheels are built
//! on it (Varghese and Lauck 1987).

/// Number of 64-bit words.
const WORDS: usize = 16;

/// A window of [`Horizon::CYCLES`] consecutive cycles, in which each cycle has a slot of its own.
#[derive(Clone, Debug, Default)]
pub(super) struct Horizon([u64; WORDS]);

impl Horizon {
    /// Number of cycles in the window, a power of two.
    pub(super) const CYCLES: u64 = 64 * WORDS as u64;

    /// The slot of cycle `at`.
    #[inline]
    pub(super) fn slot(at: u64) -> usize {
        (at % Self::CYCLES) as usize
    }

    /// Marks slot `slot` as filled.
    #[inline]
    pub(super) fn fill(&mut self, slot: usize) {
        self.0[slot / 64] |= 1 << (slot % 64);
    }

    /// Marks slot `slot` as empty.
    #[inline]
    pub(super) fn clear(&mut self, slot: usize) {
        self.0[slot / 64] &= !(1 << (slot % 64));
    }

    /// The first filled cycle from `now` on, and its slot.
    #[inline]
    pub(super) fn next(&self, now: u64) -> Option<(u64, usize)> {
        let start = Self::slot(now);
        let slot = self.next_slot(start)?;
        Some((now + (slot + Self::CYCLES as usize - start) as u64 % Self::CYCLES, slot))
    }

    #[inline]
    fn next_slot(&self, start: usize) -> Option<usize> {
        let first = self.0[start / 64] & !0 << (start % 64);
        if first != 0 {
            return Some(start / 64 * 64 + first.trailing_zeros() as usize);
        }
        // The last word of the search is the first one again, for the slots before the slot of `now`.
        let word = (1..=WORDS).map(|step| (start / 64 + step) % WORDS).find(|&word| self.0[word] != 0)?;
        Some(word * 64 + self.0[word].trailing_zeros() as usize)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_next_cycle_is_the_first_that_was_filled(
            now in 0u64..5000, filled in prop::collection::btree_set(0..Horizon::CYCLES, 0..8),
        ) {
            let mut horizon = Horizon::default();
            filled.iter().for_each(|ahead| horizon.fill(Horizon::slot(now + ahead)));
            let mut found = Vec::new();
            while let Some((at, slot)) = horizon.next(now) {
                found.push(at - now);
                prop_assert_eq!(slot, Horizon::slot(at));
                horizon.clear(slot);
            }
            prop_assert!(found.into_iter().eq(filled));
        }
    }
}
