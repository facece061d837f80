//! The bounded queue between two parts: each link takes a cycle, and a freed place is usable one cycle later.

use super::ring::Ring;
use super::{PartId, Wake};

/// A first-in first-out queue with a limited number of places. An entry can be taken from its stamped cycle on. A place
/// freed in cycle `t` is free from `t + 1` on.
#[derive(Clone, Debug)]
pub(crate) struct Queue<T> {
    entries: Ring<(u64, T)>,
    capacity: usize,
    last_taken: u64,
    taken_then: usize,
    waiting: Vec<PartId>,
    load: Load,
    /// The cycle up to which `load.occupied` is counted.
    counted_to: u64,
}

/// Load of a queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Entries put in.
    pub entries: u64,
    /// Cycles from put to take, summed over the entries taken.
    pub waited: u64,
    /// Occupied places at the ends of cycles, summed over cycles.
    pub occupied: u64,
}

impl<T: Copy> Queue<T> {
    /// An empty queue of `capacity` places.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            entries: Ring::new(),
            capacity,
            last_taken: 0,
            taken_then: 0,
            waiting: Vec::new(),
            load: Load::default(),
            counted_to: 0,
        }
    }

    /// Whether a place is free in cycle `now`.
    #[inline]
    pub(crate) fn has_room(&self, now: u64) -> bool {
        let freed_now = if self.last_taken == now { self.taken_then } else { 0 };
        self.entries.len() + freed_now < self.capacity
    }

    /// Puts `entry` in cycle `at - 1`; it can be taken from cycle `at` on. The caller has checked for room.
    #[inline]
    pub(crate) fn put(&mut self, entry: T, at: u64) {
        debug_assert!(self.entries.len() < self.capacity);
        self.count_to(at - 1);
        self.load.entries += 1;
        self.entries.push_back((at, entry));
    }

    /// The first entry, if it can be taken in cycle `now`.
    #[inline]
    pub(crate) fn first(&self, now: u64) -> Option<T> {
        self.entries.front().filter(|(at, _)| *at <= now).map(|&(_, entry)| entry)
    }

    /// Takes the first entry in cycle `now`, and wakes the parts that wait for a place.
    #[inline(always)]
    pub(crate) fn take(&mut self, now: u64, wake: &mut impl Wake) -> Option<T> {
        // Inlined check: most queues are empty when polled.
        let &(at, entry) = self.entries.front().filter(|(at, _)| *at <= now)?;
        self.take_first(at, now, wake);
        Some(entry)
    }

    fn take_first(&mut self, at: u64, now: u64, wake: &mut impl Wake) {
        self.count_to(now);
        self.entries.drop_front();
        self.taken(at, now, wake);
    }

    /// Takes entry `index` in cycle `now`, ahead of the entries before it.
    pub(crate) fn take_at(&mut self, index: usize, now: u64, wake: &mut impl Wake) -> Option<T> {
        self.count_to(now);
        let (at, entry) = self.entries.remove(index)?;
        self.taken(at, now, wake);
        Some(entry)
    }

    /// Adds the occupied places at the ends of the cycles before `now`.
    #[inline]
    fn count_to(&mut self, now: u64) {
        self.load.occupied += self.entries.len() as u64 * (now - self.counted_to);
        self.counted_to = now;
    }

    /// The load up to the last put or take.
    pub(crate) fn load(&self) -> Load {
        self.load
    }

    /// Accounts for an entry, available from cycle `at` on, that is taken in cycle `now`.
    #[inline]
    fn taken(&mut self, at: u64, now: u64, wake: &mut impl Wake) {
        self.load.waited += now + 1 - at;
        self.taken_then = if self.last_taken == now { self.taken_then + 1 } else { 1 };
        self.last_taken = now;
        if !self.waiting.is_empty() {
            self.waiting.drain(..).for_each(|part| wake.wake(part, now + 1));
        }
    }

    /// Wakes `part`, which found no room in cycle `now`, when a place is free.
    pub(crate) fn wait_for_room(&mut self, part: PartId, now: u64, wake: &mut impl Wake) {
        if self.entries.len() < self.capacity {
            // A place was freed in this cycle: it is usable in the next.
            wake.wake(part, now + 1);
        } else if !self.waiting.contains(&part) {
            self.waiting.push(part);
        }
    }

    /// The cycle from which the first entry can be taken.
    #[inline]
    pub(crate) fn next_at(&self) -> Option<u64> {
        self.entries.front().map(|&(at, _)| at)
    }

    /// The cycle from which the last entry can be taken.
    #[inline]
    pub(crate) fn last_at(&self) -> Option<u64> {
        self.entries.back().map(|&(at, _)| at)
    }

    /// Entries that can be taken in cycle `now`, in order, with their indices.
    pub(crate) fn visible(&self, now: u64) -> impl Iterator<Item = (usize, &T)> {
        self.visible_from(0, now)
    }

    /// As [`Queue::visible`], from entry `first` on.
    #[inline]
    pub(crate) fn visible_from(&self, first: usize, now: u64) -> impl Iterator<Item = (usize, &T)> {
        let entries = self.entries.iter_from(first).take_while(move |(at, _)| *at <= now);
        (first..).zip(entries.map(|(_, entry)| entry))
    }

    /// Whether entry `index` exists and can be taken in cycle `now`.
    #[inline]
    pub(crate) fn is_visible(&self, index: usize, now: u64) -> bool {
        self.entries.get(index).is_some_and(|(at, _)| *at <= now)
    }

    /// Entry `index`.
    pub(crate) fn get(&self, index: usize) -> Option<&T> {
        self.entries.get(index).map(|(_, entry)| entry)
    }

    /// Mutable entry `index`.
    pub(crate) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        self.entries.get_mut(index).map(|(_, entry)| entry)
    }

    /// Number of entries, including those that cannot be taken yet.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is no entry.
    pub(crate) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Number of places.
    pub(crate) fn capacity(&self) -> usize {
        self.capacity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Alarms(Vec<(PartId, u64)>);

    impl Wake for Alarms {
        fn wake(&mut self, part: PartId, at: u64) {
            self.0.push((part, at));
        }
    }

    #[test]
    fn a_freed_place_can_be_used_one_cycle_later() {
        let mut alarms = Alarms::default();
        let mut queue = Queue::new(1);
        assert!(queue.has_room(5));
        queue.put('a', 6);
        assert!(!queue.has_room(5));
        queue.wait_for_room(PartId(1), 5, &mut alarms);
        assert_eq!((queue.first(5), queue.take(6, &mut alarms)), (None, Some('a')));
        assert_eq!((queue.has_room(6), queue.has_room(7)), (false, true));
        // A part that asks late in the cycle in which a place is freed is woken too.
        queue.wait_for_room(PartId(2), 6, &mut alarms);
        assert_eq!(alarms.0, [(PartId(1), 7), (PartId(2), 7)]);
    }
}
