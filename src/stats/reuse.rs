//! Misses of caches of all sizes, from reuse distances.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::traffic::TrafficClass;

/// Misses of a class in LRU caches of any size, from reuse distances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReuseCurve {
    /// Accesses.
    pub accesses: u64,
    /// Number of accesses that the sampled lines stand for; all accesses, if lines are not sampled.
    pub sampled: f64,
    /// First touches of a line by a cache.
    pub first_touches: f64,
    /// Misses, first touches included, of caches without sets, for each of [`ReuseCurve::sizes`].
    pub misses: Vec<f64>,
    /// Misses of the cache with the machine's sets, if lines fall into them at random.
    pub misses_in_sets: f64,
}

impl ReuseCurve {
    /// Sizes of caches in bytes: powers of two from 1 kB to 16 MB.
    pub fn sizes() -> impl Iterator<Item = u64> {
        (10..=24).map(|power| 1 << power)
    }
}

/// Reuse in the caches of a kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReuseLevel {
    /// The caches' name in reports.
    pub name: String,
    /// Number of caches.
    pub caches: u64,
    /// Size of each cache of the machine, in bytes.
    pub bytes: u64,
    /// Ways of each cache of the machine.
    pub ways: u64,
    /// Curves by class.
    pub classes: BTreeMap<TrafficClass, ReuseCurve>,
}

/// Reuse in the caches of a machine, in one frame of a policy's stream that is repeated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameReuse {
    /// The policy.
    pub policy: String,
    /// The frame.
    pub frame: u32,
    /// The caches.
    pub levels: Vec<ReuseLevel>,
}

impl ReuseLevel {
    /// Misses over accesses of the machine's caches, if lines fall into their sets at random; `None` without an access.
    pub fn miss_ratio_in_sets(&self) -> Option<f64> {
        let sum = |of: fn(&ReuseCurve) -> f64| self.classes.values().map(of).sum::<f64>();
        let sampled = sum(|curve| curve.sampled);
        (sampled > 0.0).then(|| sum(|curve| curve.misses_in_sets) / sampled)
    }
}
