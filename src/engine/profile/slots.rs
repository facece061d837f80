//! A resource that serves one request at a time, with requests in nearly ascending time: its free and taken slots.

use std::collections::VecDeque;

/// Words of slots that are kept. A request for an earlier time is served as if it were for the first kept slot.
const WORDS: usize = 16;

/// Slots of equal length.
#[derive(Clone, Debug)]
pub(super) struct Slots {
    length: u64,
    /// The number of the first slot of the first word; then one bit per slot, set if taken.
    first: u64,
    taken: VecDeque<u64>,
    end: u64,
}

impl Slots {
    /// Slots of `length` each, all free.
    pub(super) fn new(length: u64) -> Self {
        Self { length, first: 0, taken: vec![0; WORDS].into(), end: 0 }
    }

    /// Takes the first free slot from time `at` on; returns its beginning, or `at` if `at` lies in it.
    pub(super) fn take(&mut self, at: u64) -> u64 {
        let wanted = (at / self.length).max(self.first);
        let (mut word, mut mask) = (((wanted - self.first) / 64) as usize, !0 << ((wanted - self.first) % 64));
        loop {
            if word >= WORDS {
                let skipped = (word - WORDS + 1).min(WORDS);
                self.first += 64 * (word - WORDS + 1) as u64;
                self.taken.drain(..skipped);
                self.taken.extend(std::iter::repeat_n(0, skipped));
                word = WORDS - 1;
            }
            let free = !self.taken[word] & mask;
            if free != 0 {
                let bit = free.trailing_zeros();
                self.taken[word] |= 1 << bit;
                let begin = (self.first + 64 * word as u64 + u64::from(bit)) * self.length;
                self.end = self.end.max(begin + self.length);
                return begin.max(at);
            }
            (word, mask) = (word + 1, !0);
        }
    }

    /// The end of the last taken slot.
    pub(super) fn end(&self) -> u64 {
        self.end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_gets_the_first_free_slot_also_one_who_comes_late() {
        let mut slots = Slots::new(4);
        assert_eq!([10, 10, 13].map(|at| slots.take(at)), [10, 12, 16]);
        assert_eq!([100, 90, 90, 90].map(|at| slots.take(at)), [100, 90, 92, 96]);
        assert_eq!(slots.end(), 104);
        // Slot 250,000 is in word 3906; words are kept from 3891 on.
        assert_eq!([1_000_000, 1_000_000, 100].map(|at| slots.take(at)), [1_000_000, 1_000_004, 4 * 64 * 3891]);
    }
}
