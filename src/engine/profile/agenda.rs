//! A scheduler of numbered actors, each with at most one appointment. A timing wheel of lists, linked through the
//! actors' numbers, and a heap for appointments beyond the wheel.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::engine::horizon::Horizon;

const NONE: u32 = u32::MAX;

/// The agenda.
#[derive(Clone, Debug)]
pub(super) struct Agenda {
    now: u64,
    /// The first and the last actor of each cycle.
    lists: Vec<(u32, u32)>,
    /// The actor that follows each actor in its list.
    next: Vec<u32>,
    occupied: Horizon,
    /// (cycle, insertion number, actor)
    later: BinaryHeap<Reverse<(u64, u64, u32)>>,
    put: u64,
}

impl Agenda {
    /// An empty agenda in cycle 0 for actors below `count`.
    pub(super) fn new(count: usize) -> Self {
        Self {
            now: 0,
            lists: vec![(NONE, NONE); Horizon::CYCLES as usize],
            next: vec![NONE; count],
            occupied: Horizon::default(),
            later: BinaryHeap::new(),
            put: 0,
        }
    }

    /// Actor `who`, who has no appointment, acts in cycle `at`, which is not over.
    #[inline]
    pub(super) fn put(&mut self, at: u64, who: u32) {
        debug_assert!(at >= self.now);
        if at - self.now >= Horizon::CYCLES {
            self.put += 1;
            return self.later.push(Reverse((at, self.put, who)));
        }
        let slot = Horizon::slot(at);
        let (first, last) = &mut self.lists[slot];
        self.next[who as usize] = NONE;
        if *first == NONE {
            *first = who;
            self.occupied.fill(slot);
        } else {
            self.next[*last as usize] = who;
        }
        *last = who;
    }

    /// The next actor of the current cycle.
    #[inline]
    pub(super) fn take(&mut self) -> Option<u32> {
        let slot = Horizon::slot(self.now);
        let (first, _) = &mut self.lists[slot];
        if *first == NONE {
            return None;
        }
        let who = *first;
        *first = self.next[who as usize];
        if *first == NONE {
            self.occupied.clear(slot);
        }
        Some(who)
    }

    /// Advances to the next cycle with an appointment; `None` if there is none.
    pub(super) fn turn(&mut self) -> Option<u64> {
        let near = self.occupied.next(self.now).map(|(at, _)| at);
        let far = self.later.peek().map(|&Reverse((at, ..))| at);
        self.now = match (near, far) {
            (Some(near), Some(far)) => near.min(far),
            (near, far) => near.or(far)?,
        };
        while let Some(&Reverse((at, _, who))) = self.later.peek()
            && at == self.now
        {
            self.later.pop();
            self.put(at, who);
        }
        Some(self.now)
    }
}
