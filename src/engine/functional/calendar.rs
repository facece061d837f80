//! A timing wheel of lists: what happens in a cycle, in the order in which it was announced.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cycles that the wheel looks ahead, a power of two; what is later waits in a heap.
const HORIZON: u64 = 1024;
const WORDS: usize = HORIZON as usize / 64;

/// The calendar. Events are numbers.
#[derive(Clone, Debug)]
pub struct Calendar {
    now: u64,
    slots: Vec<Vec<u32>>,
    occupied: [u64; WORDS],
    /// When, the how-manieth, what.
    later: BinaryHeap<Reverse<(u64, u64, u32)>>,
    announced: u64,
}

impl Calendar {
    /// An empty calendar, in cycle 0.
    pub fn new() -> Self {
        let slots = vec![Vec::new(); HORIZON as usize];
        Self { now: 0, slots, occupied: [0; WORDS], later: BinaryHeap::new(), announced: 0 }
    }

    /// Announces `event` for cycle `at`, which is not over.
    pub fn put(&mut self, at: u64, event: u32) {
        debug_assert!(at >= self.now);
        if at - self.now < HORIZON {
            let slot = (at % HORIZON) as usize;
            self.slots[slot].push(event);
            self.occupied[slot / 64] |= 1 << (slot % 64);
        } else {
            self.announced += 1;
            self.later.push(Reverse((at, self.announced, event)));
        }
    }

    /// Goes on to the next cycle in which something happens and puts that into `events`; `None` if nothing more does.
    pub fn turn(&mut self, events: &mut Vec<u32>) -> Option<u64> {
        let near = self.first_occupied().map(|slot| {
            let start = (self.now % HORIZON) as usize;
            self.now + (slot + HORIZON as usize - start) as u64 % HORIZON
        });
        let far = self.later.peek().map(|&Reverse((at, ..))| at);
        self.now = match (near, far) {
            (Some(near), Some(far)) => near.min(far),
            (near, far) => near.or(far)?,
        };
        events.clear();
        while let Some(&Reverse((at, _, event))) = self.later.peek()
            && at == self.now
        {
            events.push(event);
            self.later.pop();
        }
        let slot = (self.now % HORIZON) as usize;
        events.append(&mut self.slots[slot]);
        self.occupied[slot / 64] &= !(1 << (slot % 64));
        Some(self.now)
    }

    fn first_occupied(&self) -> Option<usize> {
        let start = (self.now % HORIZON) as usize;
        (0..=WORDS).find_map(|step| {
            let word = (start / 64 + step) % WORDS;
            let mut bits = self.occupied[word];
            if step == 0 {
                bits &= !0 << (start % 64);
            } else if step == WORDS {
                bits &= !(!0 << (start % 64));
            }
            (bits != 0).then(|| word * 64 + bits.trailing_zeros() as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_in_order_near_and_far() {
        let mut calendar = Calendar::new();
        for (at, event) in [(5, 1), (5000, 2), (5, 3), (1023, 4), (1024, 5), (5000, 6)] {
            calendar.put(at, event);
        }
        let (mut seen, mut events) = (Vec::new(), Vec::new());
        while let Some(now) = calendar.turn(&mut events) {
            seen.push((now, events.clone()));
            if now == 1023 {
                calendar.put(1024, 7);
                calendar.put(1023 + 1024, 8);
            }
        }
        let expected = vec![(5, vec![1, 3]), (1023, vec![4]), (1024, vec![5, 7]), (2047, vec![8]), (5000, vec![2, 6])];
        assert_eq!(seen, expected);
    }
}
