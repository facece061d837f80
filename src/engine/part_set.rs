//! Sets of parts, as bitmaps.

use crate::memory::PartId;

/// A range of consecutive parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    /// The first part.
    pub first: u32,
    /// The part after the last.
    pub end: u32,
    /// The range's bits in a set's first word, if the range lies there (most machines need no other word); else 0.
    in_first: u64,
    /// Whether the range reaches beyond the first word.
    elsewhere: bool,
    /// The range's bits, if they lie in one word of a set; else 0.
    mask: u64,
}

impl Range {
    /// Parts `first` to `end - 1`.
    pub(super) fn new(first: u32, end: u32) -> Self {
        let in_one_word = first < end && first / 64 == (end - 1) / 64;
        let mask = if in_one_word { (!0 << (first % 64)) & (!0 >> (63 - (end - 1) % 64)) } else { 0 };
        let elsewhere = first < end && end > 64;
        Self { first, end, in_first: if elsewhere { 0 } else { mask }, elsewhere, mask }
    }
}

/// How many parts of a range are in a set, and which one if it is the only one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Members {
    None,
    One(u32),
    Several,
}

/// Classifies the bits of a word whose lowest bit stands for part `first`.
#[inline(always)]
fn members(bits: u64, first: u32) -> Members {
    match bits {
        0 => Members::None,
        _ if bits & (bits - 1) == 0 => Members::One(first + bits.trailing_zeros()),
        _ => Members::Several,
    }
}

/// A set of parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PartSet {
    first: u64,
    others: Vec<u64>,
}

impl PartSet {
    /// An empty set for parts 0 to `parts - 1`.
    pub(super) fn new(parts: usize) -> Self {
        Self { first: 0, others: vec![0; parts.div_ceil(64).saturating_sub(1)] }
    }

    /// Replaces this set by the one in `words`, which has the same size, and clears `words`.
    #[inline]
    pub(super) fn take_from(&mut self, words: &mut [u64]) {
        let [first, others @ ..] = words else { return };
        self.first = std::mem::take(first);
        for (own, word) in self.others.iter_mut().zip(others) {
            *own = std::mem::take(word);
        }
    }

    #[inline]
    fn word(&self, at: usize) -> u64 {
        if at == 0 { self.first } else { self.others[at - 1] }
    }

    #[inline]
    fn word_of(&mut self, part: u32) -> &mut u64 {
        match part as usize / 64 {
            0 => &mut self.first,
            at => &mut self.others[at - 1],
        }
    }

    /// Adds a part.
    pub(super) fn add(&mut self, part: u32) {
        *self.word_of(part) |= 1 << (part % 64);
    }

    /// Removes a part.
    pub(super) fn remove(&mut self, part: u32) {
        *self.word_of(part) &= !(1 << (part % 64));
    }

    /// Whether a part is in the set.
    #[inline]
    pub(super) fn has(&self, part: PartId) -> bool {
        self.word(part.0 as usize / 64) & 1 << (part.0 % 64) != 0
    }

    /// Which parts of a range are in the set.
    #[inline(always)]
    pub(super) fn within(&self, parts: Range) -> Members {
        if !parts.elsewhere {
            return members(self.first & parts.in_first, 0);
        }
        self.within_words(parts.first, parts.end, parts.mask)
    }

    /// [`PartSet::within`] for a range beyond the first word; `mask` is 0 if the range lies in several words.
    fn within_words(&self, first: u32, end: u32, mask: u64) -> Members {
        if mask == 0 {
            return match self.next(first, end) {
                None => Members::None,
                Some(part) if self.next(part + 1, end).is_none() => Members::One(part),
                Some(_) => Members::Several,
            };
        }
        members(self.word(first as usize / 64) & mask, first / 64 * 64)
    }

    /// Calls `act` for all parts of the set from `first` to `end - 1`, in order.
    #[inline]
    pub(super) fn each(&self, first: u32, end: u32, mut act: impl FnMut(u32)) {
        let mut at = first;
        while at < end {
            let word = at / 64;
            let until = end.min(64 * (word + 1));
            let mut bits = self.word(word as usize) & !0 << (at % 64) & !0 >> (64 * (word + 1) - until);
            while bits != 0 {
                act(64 * word + bits.trailing_zeros());
                bits &= bits - 1;
            }
            at = until;
        }
    }

    /// The first part of the set from `from` to `end - 1`.
    #[inline]
    pub(super) fn next(&self, from: u32, end: u32) -> Option<u32> {
        let mut word = from as usize / 64;
        if word > self.others.len() {
            return None;
        }
        let mut bits = self.word(word) & !0 << (from % 64);
        loop {
            if bits != 0 {
                let part = word as u32 * 64 + bits.trailing_zeros();
                return (part < end).then_some(part);
            }
            word += 1;
            if word as u32 * 64 >= end || word > self.others.len() {
                return None;
            }
            bits = self.word(word);
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
        for (first, end) in [(0, 130), (3, 3), (63, 65), (64, 128), (70, 71)] {
            let mut found = Vec::new();
            set.each(first, end, |part| found.push(part));
            assert_eq!(found, (first..end).collect::<Vec<_>>());
            let expected = match end - first {
                0 => Members::None,
                1 => Members::One(first),
                _ => Members::Several,
            };
            assert_eq!(set.within(Range::new(first, end)), expected, "{first} to {end}");
        }
        assert_eq!((set.next(70, 71), set.next(71, 71), set.next(64, 130)), (Some(70), None, Some(64)));
        (65..130).for_each(|part| set.remove(part));
        assert_eq!((set.next(64, 130), set.next(65, 130)), (Some(64), None));
    }
}
