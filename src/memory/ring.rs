//! A queue in a buffer whose size is a power of two, so that a mask gives the places. The machine's queues are short
//! and their entries small: put and take are a few instructions each.

/// A first-in first-out queue that grows when it is full.
#[derive(Clone, Debug)]
pub(crate) struct Ring<T> {
    /// Zero or a power of two of places. Places without an entry hold stale values.
    places: Vec<T>,
    /// Index of the first entry, below the number of places if there are any.
    first: usize,
    len: usize,
}

impl<T> Default for Ring<T> {
    fn default() -> Self {
        Self { places: Vec::new(), first: 0, len: 0 }
    }
}

impl<T: Copy> Ring<T> {
    /// An empty queue.
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// The number of entries.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no entry.
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[inline]
    fn place(&self, index: usize) -> usize {
        (self.first + index) & self.places.len().wrapping_sub(1)
    }

    /// The first entry.
    #[inline]
    pub(crate) fn front(&self) -> Option<&T> {
        self.places.get(self.first).filter(|_| self.len > 0)
    }

    /// The last entry.
    #[inline]
    pub(crate) fn back(&self) -> Option<&T> {
        if self.len == 0 { None } else { self.places.get(self.place(self.len - 1)) }
    }

    /// Entry `index`.
    #[inline]
    pub(crate) fn get(&self, index: usize) -> Option<&T> {
        if index < self.len { self.places.get(self.place(index)) } else { None }
    }

    /// Mutable entry `index`.
    #[inline]
    pub(crate) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        if index >= self.len {
            return None;
        }
        let place = self.place(index);
        self.places.get_mut(place)
    }

    /// Puts `entry` behind all others.
    #[inline]
    pub(crate) fn push_back(&mut self, entry: T) {
        if self.len == self.places.len() {
            self.grow(entry);
        }
        let place = self.place(self.len);
        self.places[place] = entry;
        self.len += 1;
    }

    #[cold]
    fn grow(&mut self, filler: T) {
        let mut places: Vec<T> = self.iter().copied().collect();
        places.resize((2 * self.len).max(4), filler);
        (self.places, self.first) = (places, 0);
    }

    /// Takes the first entry.
    #[inline]
    pub(crate) fn pop_front(&mut self) -> Option<T> {
        let entry = *self.front()?;
        self.drop_front();
        Some(entry)
    }

    /// Drops the first entry, which must exist.
    #[inline]
    pub(crate) fn drop_front(&mut self) {
        debug_assert!(self.len > 0);
        self.first = self.place(1);
        self.len -= 1;
    }

    /// Takes entry `index`; later entries move up.
    pub(crate) fn remove(&mut self, index: usize) -> Option<T> {
        let entry = *self.get_mut(index)?;
        for place in (0..index).rev() {
            let (from, to) = (self.place(place), self.place(place + 1));
            self.places[to] = self.places[from];
        }
        self.drop_front();
        Some(entry)
    }

    /// Inserts `entry` after the last entry whose key is not greater. The keys are in ascending order.
    pub(crate) fn insert_by_key<K: PartialOrd>(&mut self, entry: T, key: impl Fn(&T) -> K) {
        self.push_back(entry);
        for index in (1..self.len).rev() {
            let (before, at) = (self.place(index - 1), self.place(index));
            if key(&self.places[before]) <= key(&entry) {
                return;
            }
            self.places.swap(before, at);
        }
    }

    /// The entries in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> + Clone {
        self.iter_from(0)
    }

    /// The entries in order, from entry `first` on.
    #[inline]
    pub(crate) fn iter_from(&self, first: usize) -> impl Iterator<Item = &T> + Clone {
        (first..self.len).map(|index| &self.places[self.place(index)])
    }
}

impl<T: Copy> Extend<T> for Ring<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, entries: I) {
        entries.into_iter().for_each(|entry| self.push_back(entry));
    }
}

impl<T: Copy> FromIterator<T> for Ring<T> {
    fn from_iter<I: IntoIterator<Item = T>>(entries: I) -> Self {
        let mut ring = Self::new();
        ring.extend(entries);
        ring
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The ring behaves as the standard library's queue.
        #[test]
        fn a_ring_is_a_queue(steps in prop::collection::vec((0..4u8, 0..100u32), 1..200)) {
            let (mut ring, mut queue) = (Ring::new(), VecDeque::new());
            for (what, value) in steps {
                match what {
                    0 | 1 => {
                        ring.push_back(value);
                        queue.push_back(value);
                    }
                    2 => prop_assert_eq!(ring.pop_front(), queue.pop_front()),
                    _ => prop_assert_eq!(ring.remove(value as usize % 8), queue.remove(value as usize % 8)),
                }
                prop_assert_eq!((ring.front(), ring.back(), ring.len()), (queue.front(), queue.back(), queue.len()));
                prop_assert!(ring.iter().eq(queue.iter()));
            }
        }
    }

    #[test]
    fn entries_of_the_same_key_keep_their_order() {
        let mut ring = Ring::new();
        for entry in [(3, 'a'), (1, 'b'), (3, 'c'), (2, 'd'), (1, 'e')] {
            ring.insert_by_key(entry, |entry| entry.0);
        }
        assert!(ring.iter().copied().eq([(1, 'b'), (1, 'e'), (2, 'd'), (3, 'a'), (3, 'c')]));
    }
}
