//! Cache contents at the start of a replay.

use std::sync::Arc;

use crate::machine::kinds::Kind;
use crate::memory::timeless::TimelessCache;

/// The L1s of each kind of units, core by core.
pub(crate) type L1s = [Vec<TimelessCache>; Kind::ALL.len()];

/// The contents of a machine's caches.
#[derive(Clone, Debug)]
pub(crate) struct WarmCaches {
    /// L1s of all units but the shadow-cache units.
    pub path: Arc<L1s>,
    /// L1s of the shadow-cache units.
    pub words: Arc<Vec<TimelessCache>>,
    /// The banks of the L2s, core by core.
    pub banks: Arc<Vec<TimelessCache>>,
}

impl WarmCaches {
    /// The L1s of a kind of units, core by core.
    pub(crate) fn l1s(&self, kind: Kind) -> &[TimelessCache] {
        if kind == Kind::ShadowCache { &self.words } else { &self.path[kind as usize] }
    }

    /// Approximate size in memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let all = Kind::ALL.into_iter().flat_map(|kind| self.l1s(kind)).chain(self.banks.iter());
        all.map(TimelessCache::bytes).sum()
    }
}
