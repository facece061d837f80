//! What caches hold when something is replayed.

use std::sync::Arc;

use crate::machine::kinds::Kind;
use crate::memory::timeless::TimelessCache;

/// The L1s of each kind of units, core by core.
pub(crate) type L1s = [Vec<TimelessCache>; Kind::ALL.len()];

/// What the caches of a machine hold.
#[derive(Clone, Debug)]
pub(crate) struct WarmCaches {
    l1s: Arc<L1s>,
    banks: Arc<Vec<TimelessCache>>,
}

impl WarmCaches {
    /// Those with what these L1s, and these banks of the L2s, hold.
    pub(crate) fn new(l1s: Arc<L1s>, banks: Arc<Vec<TimelessCache>>) -> Self {
        Self { l1s, banks }
    }

    /// The L1s of a kind of units, core by core.
    pub(crate) fn l1s(&self, kind: Kind) -> &[TimelessCache] {
        &self.l1s[kind as usize]
    }

    /// The banks of the L2s, core by core.
    pub(crate) fn banks(&self) -> &[TimelessCache] {
        &self.banks
    }

    /// What they take in memory, about.
    pub(crate) fn bytes(&self) -> usize {
        self.l1s.iter().flatten().chain(self.banks.iter()).map(TimelessCache::bytes).sum()
    }
}
