//! Packed steps, as a traversal writes them down.

use std::ops::Deref;

/// Packed steps in a buffer that is longer than they are. A traversal asks for room before it visits something, where
/// it has nothing to save from a call that allocates, and then only writes.
#[derive(Clone, Debug, Default)]
pub struct Steps {
    /// The steps, and behind them room.
    words: Vec<u32>,
    length: usize,
}

impl Steps {
    /// How many steps [`Steps::make_room`] makes room for.
    pub(super) const ROOM: usize = 8;
    /// Words of the first buffer.
    const FIRST: usize = 256;

    /// Makes room for some steps.
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

    /// Writes the first `count` of some words, for all of which there is room.
    #[inline(always)]
    pub(super) fn write<const M: usize>(&mut self, words: [u32; M], count: usize) {
        const { assert!(M <= Self::ROOM) };
        self.words[self.length..self.length + M].copy_from_slice(&words);
        self.length += count;
    }

    /// Writes a step.
    #[inline]
    pub(super) fn push(&mut self, word: u32) {
        self.make_room();
        self.write([word], 1);
    }

    /// Forgets all steps, keeps the memory.
    pub(super) fn clear(&mut self) {
        self.length = 0;
    }

    /// The steps alone.
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
