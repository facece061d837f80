//! A timing wheel whose slots are sets of parts: the parts due in a cycle, each once and in their order.

use crate::engine::horizon::Horizon;
use crate::engine::part_set::PartSet;
use crate::memory::{PartId, Wake};

/// The wheel. An alarm beyond its horizon rings at the horizon; the part then finds nothing to do and sets it again.
#[derive(Clone, Debug)]
pub(crate) struct Wheel {
    now: u64,
    /// Words per set.
    words: usize,
    /// One set per slot.
    sets: Vec<u64>,
    occupied: Horizon,
}

impl Wheel {
    /// An empty wheel for parts 0 to `parts - 1`, before cycle 0.
    pub(crate) fn new(parts: usize) -> Self {
        let words = parts.div_ceil(64);
        Self { now: 0, words, sets: vec![0; words * Horizon::CYCLES as usize], occupied: Horizon::default() }
    }

    /// The current cycle of the wheel.
    pub(crate) fn now(&self) -> u64 {
        self.now
    }

    /// Turns to the first cycle in which a part is due, and moves the due parts into `due`. Returns `None` if no part
    /// is due.
    #[inline]
    pub(crate) fn turn(&mut self, due: &mut PartSet) -> Option<u64> {
        let (now, slot) = self.occupied.next(self.now)?;
        self.now = now;
        self.occupied.clear(slot);
        due.take_from(&mut self.sets[slot * self.words..][..self.words]);
        Some(now)
    }

    /// [`Wake::wake`], unless `at` is [`u64::MAX`].
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
        let slot = Horizon::slot(at.min(self.now + Horizon::CYCLES - 1));
        self.sets[slot * self.words + part.0 as usize / 64] |= 1 << (part.0 % 64);
        self.occupied.fill(slot);
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
        assert_eq!(wheel.turn(&mut due), Some(1023 + Horizon::CYCLES - 1), "a far alarm rings at the wheel's edge");
    }
}
