//! A queue between two parts, in two phases: parts put and take during a cycle; `settle` applies the effects at its
//! end.

use std::collections::VecDeque;

use crate::memory::queue::Load;

/// A queue. An entry can be taken `latency` cycles after its put; a freed place is usable in the next cycle.
#[derive(Clone, Debug)]
pub(super) struct Link<T> {
    places: usize,
    latency: u64,
    entries: VecDeque<(u64, T)>,
    put: Vec<(u64, T)>,
    /// Free places at the beginning of the cycle.
    free: usize,
    /// The current cycle.
    now: u64,
    load: Load,
}

impl<T> Link<T> {
    /// An empty queue of `places` places.
    pub(super) fn new(places: usize, latency: u64) -> Self {
        Self { places, latency, entries: VecDeque::new(), put: Vec::new(), free: places, now: 0, load: Load::default() }
    }

    /// An empty queue without a limit of places.
    pub(super) fn unbounded() -> Self {
        Self::new(usize::MAX, 1)
    }

    /// Whether a place is free.
    pub(super) fn has_room(&self) -> bool {
        self.put.len() < self.free
    }

    /// Puts `entry` in cycle `now`.
    pub(super) fn put(&mut self, now: u64, entry: T) {
        assert!(self.has_room(), "whoever puts has asked for room");
        self.put.push((now + self.latency, entry));
    }

    /// The first entry, if it can be taken in cycle `now`.
    pub(super) fn first(&self, now: u64) -> Option<&T> {
        self.entries.front().filter(|(at, _)| *at <= now).map(|(_, entry)| entry)
    }

    /// Takes the first entry, if that is possible in cycle `now`.
    pub(super) fn take(&mut self, now: u64) -> Option<T> {
        self.first(now)?;
        self.remove(0)
    }

    /// Entries that can be taken in cycle `now`, in order.
    pub(super) fn entries(&mut self, now: u64) -> impl Iterator<Item = &mut T> {
        self.entries.iter_mut().filter(move |(at, _)| *at <= now).map(|(_, entry)| entry)
    }

    /// Entries that can be taken from cycle `now` on, not earlier, in order.
    pub(super) fn came(&self, now: u64) -> impl Iterator<Item = &T> {
        self.entries.iter().filter(move |(at, _)| *at == now).map(|(_, entry)| entry)
    }

    /// Takes entry `index`, ahead of the entries before it.
    pub(super) fn remove(&mut self, index: usize) -> Option<T> {
        let (at, entry) = self.entries.remove(index)?;
        self.load.waited += self.now - (at - self.latency);
        Some(entry)
    }

    /// Ends the cycle: entries that were put become part of the queue; places that were freed become usable.
    pub(super) fn settle(&mut self) {
        self.load.entries += self.put.len() as u64;
        self.entries.extend(self.put.drain(..));
        self.load.occupied += self.entries.len() as u64;
        self.now += 1;
        self.free = self.places - self.entries.len();
    }

    /// Load of the queue.
    pub(super) fn load(&self) -> Load {
        self.load
    }

    /// Whether the queue has no entry, including entries put in this cycle.
    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty() && self.put.is_empty()
    }

    /// Number of entries, for the report of a deadlock.
    pub(super) fn len(&self) -> usize {
        self.entries.len() + self.put.len()
    }
}
