//! Which of the next cycles hold something: a bit a cycle, round and round. Timing wheels are made of it (Varghese and
//! Lauck 1987).

/// Words of bits.
const WORDS: usize = 16;

/// The cycles from one on, [`Horizon::CYCLES`] of them: each has a slot, which it shares with no other of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Horizon([u64; WORDS]);

impl Horizon {
    /// How many cycles it spans, a power of two.
    pub(super) const CYCLES: u64 = 64 * WORDS as u64;

    /// The slot of cycle `at`.
    #[inline]
    pub(super) fn slot(at: u64) -> usize {
        (at % Self::CYCLES) as usize
    }

    /// Slot `slot` holds something.
    #[inline]
    pub(super) fn fill(&mut self, slot: usize) {
        self.0[slot / 64] |= 1 << (slot % 64);
    }

    /// Slot `slot` holds nothing any more.
    #[inline]
    pub(super) fn clear(&mut self, slot: usize) {
        self.0[slot / 64] &= !(1 << (slot % 64));
    }

    /// The first cycle from `now` on that holds something, and its slot.
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
        // The last word is the first again, for the slots before that of `now`.
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
