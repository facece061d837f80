//! A timing wheel whose slots are sets of parts: what is due in a cycle, in the parts' order, each part once.

use crate::engine::part_set::PartSet;
use crate::memory::{PartId, Wake};

/// Cycles that the wheel looks ahead, a power of two. A later alarm rings at its edge, and the part, finding nothing to
/// do, sets it again.
const HORIZON: u64 = 1024;

/// The wheel.
#[derive(Clone, Debug)]
pub(crate) struct Wheel {
    now: u64,
    /// Words of a set.
    words: usize,
    /// `HORIZON` sets.
    slots: Vec<u64>,
    /// A bit a slot: whether its set may have a member.
    occupied: [u64; HORIZON as usize / 64],
}

impl Wheel {
    /// An empty wheel for parts below `parts`, before cycle 0.
    pub(crate) fn new(parts: usize) -> Self {
        let words = parts.div_ceil(64);
        Self { now: 0, words, slots: vec![0; words * HORIZON as usize], occupied: [0; HORIZON as usize / 64] }
    }

    /// The cycle that the wheel is turned to.
    pub(crate) fn now(&self) -> u64 {
        self.now
    }

    /// Turns to the first cycle in which a part is due and puts the parts into `due`; `None` if no part is.
    #[inline]
    pub(crate) fn turn(&mut self, due: &mut PartSet) -> Option<u64> {
        let slot = self.next_slot()?;
        let start = self.now as usize % HORIZON as usize;
        self.now += (slot + HORIZON as usize - start) as u64 % HORIZON;
        self.occupied[slot / 64] &= !(1 << (slot % 64));
        due.take_from(&mut self.slots[slot * self.words..][..self.words]);
        Some(self.now)
    }

    /// The first slot with a member, round from that of the current cycle on.
    #[inline]
    fn next_slot(&self) -> Option<usize> {
        let start = self.now as usize % HORIZON as usize;
        let bits = self.occupied[start / 64] & !0 << (start % 64);
        if bits != 0 {
            return Some(start / 64 * 64 + bits.trailing_zeros() as usize);
        }
        // The last word is the first again, for the slots before the current one.
        let words = self.occupied.len();
        let word = (1..=words).map(|step| (start / 64 + step) % words).find(|&word| self.occupied[word] != 0)?;
        Some(word * 64 + self.occupied[word].trailing_zeros() as usize)
    }
}

impl Wheel {
    /// As [`Wake::wake`]; [`u64::MAX`] is no cycle.
    #[inline]
    pub(crate) fn wake_if(&mut self, part: PartId, at: u64) {
        if at != u64::MAX {
            self.wake(part, at);
        }
    }
}

impl Wake for Wheel {
    #[inline]
    fn wake(&mut self, part: PartId, at: u64) {
        debug_assert!(at > self.now || self.now == 0);
        let slot = (at.min(self.now + HORIZON - 1) % HORIZON) as usize;
        self.slots[slot * self.words + part.0 as usize / 64] |= 1 << (part.0 % 64);
        self.occupied[slot / 64] |= 1 << (slot % 64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_ring_once_in_order_of_time() {
        let mut wheel = Wheel::new(130);
        let mut due = PartSet::new(130);
        for (part, at) in [(129, 7), (3, 7), (3, 7), (64, 1), (5, 1023)] {
            wheel.wake(PartId(part), at);
        }
        let mut rung = Vec::new();
        while let Some(now) = wheel.turn(&mut due) {
            let mut from = 0;
            while let Some(part) = due.next(from, 130) {
                rung.push((now, part));
                from = part + 1;
            }
        }
        assert_eq!(rung, [(1, 64), (7, 3), (7, 129), (1023, 5)]);
        wheel.wake(PartId(9), 1023 + 5000);
        assert_eq!(wheel.turn(&mut due), Some(1023 + HORIZON - 1), "a far alarm rings at the wheel's edge");
    }
}
