//! The versions of a ray stream file that can be read, and what differs between them.
//!
//! Version 2 differs from version 3:
//! - Totals are the first 14 counters of `Totals`: repeated and silent updates are not counted.
//! - A packed step has a tag of 4 bits and an id of 28.
//! - Updates of mode words have no recorded effect ([`super::Header::unjudged_updates`]).

use super::fault::Fault;
use super::step::Step;
use super::totals::Totals;

/// A version of the layout that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Version {
    /// Updates of mode words have no recorded effect.
    Two = 2,
    /// The current version.
    Three = 3,
}

impl Version {
    /// The version that is written.
    pub(crate) const CURRENT: Self = Self::Three;

    /// Bits of an id in a packed step of version 2.
    const OLD_INDEX_BITS: u32 = 28;
    /// Number of tags in version 2: the current tags without those of repeated and silent updates.
    const OLD_TAGS: u32 = 14;

    /// The version with a number.
    pub(super) fn of(number: u32) -> Option<Self> {
        [Self::Two, Self::Three].into_iter().find(|version| version.number() == number)
    }

    /// Its number in a file.
    pub(crate) fn number(self) -> u32 {
        self as u32
    }

    /// Number of counters of `Totals` that a file holds.
    pub(super) fn totals(self) -> usize {
        match self {
            Self::Two => 14,
            Self::Three => Totals::DECLARED.len(),
        }
    }

    /// Converts packed steps of a file to the current tags.
    pub(super) fn steps(self, words: Vec<u32>) -> Result<Vec<u32>, Fault> {
        match self {
            Self::Two => words.into_iter().map(Self::today).collect(),
            Self::Three => Ok(words),
        }
    }

    /// Converts a packed step of version 2 to the current tags.
    fn today(word: u32) -> Result<u32, Fault> {
        let (tag, id) = (word >> Self::OLD_INDEX_BITS, word & ((1 << Self::OLD_INDEX_BITS) - 1));
        if tag >= Self::OLD_TAGS {
            return Err(Fault::OldStep { word });
        }
        if id > Step::MAX_INDEX {
            return Err(Fault::OldId { id });
        }
        Ok(Step::packed(tag, id))
    }
}
