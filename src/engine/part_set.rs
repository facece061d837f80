//! Sets of parts, a bit each.

/// The set.
#[derive(Clone, Debug, Default)]
pub struct PartSet(Vec<u64>);

impl PartSet {
    /// An empty set of parts below `parts`.
    pub fn new(parts: usize) -> Self {
        Self(vec![0; parts.div_ceil(64)])
    }

    /// Replaces this set by the one in `words` and clears `words`.
    #[inline]
    pub fn take_from(&mut self, words: &mut [u64]) {
        self.0.resize(words.len(), 0);
        for (own, word) in self.0.iter_mut().zip(words) {
            *own = std::mem::take(word);
        }
    }

    /// Adds a part.
    pub fn add(&mut self, part: u32) {
        self.0[part as usize / 64] |= 1 << (part % 64);
    }

    /// Removes a part.
    pub fn remove(&mut self, part: u32) {
        self.0[part as usize / 64] &= !(1 << (part % 64));
    }

    /// The first part from `from` to before `end`.
    #[inline]
    pub fn next(&self, from: u32, end: u32) -> Option<u32> {
        let mut word = from as usize / 64;
        let mut bits = *self.0.get(word)? & !0 << (from % 64);
        loop {
            if bits != 0 {
                let part = word as u32 * 64 + bits.trailing_zeros();
                return (part < end).then_some(part);
            }
            word += 1;
            if word as u32 * 64 >= end {
                return None;
            }
            bits = *self.0.get(word)?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_ends_where_it_is_told() {
        let mut set = PartSet::new(130);
        (0..130).for_each(|part| set.add(part));
        assert_eq!((set.next(70, 71), set.next(71, 71), set.next(64, 130)), (Some(70), None, Some(64)));
        (65..130).for_each(|part| set.remove(part));
        assert_eq!((set.next(64, 130), set.next(65, 130)), (Some(64), None));
    }
}
