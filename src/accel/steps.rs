//! Packed steps in the form that a traversal writes.

use std::ops::Deref;

/// Packed steps in a buffer with spare room. A traversal asks for room before each visit, where it has no registers to
/// save around a call that allocates. After that it only writes.
#[derive(Clone, Debug, Default)]
pub struct Steps {
    /// The steps, followed by spare room.
    words: Vec<u32>,
    length: usize,
}

impl Steps {
    /// Number of steps that [`Steps::make_room`] makes room for.
    pub(super) const ROOM: usize = 8;
    /// Number of words of the first buffer.
    const FIRST: usize = 256;

    /// Makes room for [`Steps::ROOM`] steps.
    #[inline(always)]
    pub(super) fn make_room(&mut self) {
        if self.words.len() < self.length + Self::ROOM {
            self.grow();
        }
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        self.words.resize((2 * self.words.len()).max(Self::FIRST), 0);
    }

    /// Appends the first `count` of `words`. There must be room for all of `words`.
    #[inline(always)]
    pub(super) fn write<const M: usize>(&mut self, words: [u32; M], count: usize) {
        const { assert!(M <= Self::ROOM) };
        self.words[self.length..self.length + M].copy_from_slice(&words);
        self.length += count;
    }

    /// Appends a step.
    #[inline]
    pub(super) fn push(&mut self, word: u32) {
        self.make_room();
        self.write([word], 1);
    }

    /// Removes all steps and keeps the memory.
    pub(super) fn clear(&mut self) {
        self.length = 0;
    }

    /// The steps without spare room.
    pub fn into_vec(mut self) -> Vec<u32> {
        self.words.truncate(self.length);
        self.words
    }
}

impl Deref for Steps {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.words[..self.length]
    }
}
