//! Misses of caches of all sizes.

use serde::{Deserialize, Serialize};

use crate::report::format::{exact, percent};
use crate::report::grid::Grid;
use crate::stats::{MachineStats, ReuseCurve, ReuseLevel};

/// Reuse in the caches of a machine on a stream; `summary.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ReuseSummary {
    /// The machine's name.
    pub machine: String,
    /// The stream's scene and policy.
    pub scene: String,
    /// The stream's policy.
    pub policy: String,
    /// The accesses whose reuse was measured, in words.
    pub of: String,
    /// The machine's statistics.
    pub stats: MachineStats,
    /// The caches.
    pub levels: Vec<ReuseLevel>,
}

/// Formats the size of a cache.
pub(super) fn size(bytes: u64) -> String {
    if bytes < 1 << 20 {
        format!("{} KiB", bytes as f64 / 1024.0)
    } else {
        format!("{} MiB", bytes as f64 / 1024.0 / 1024.0)
    }
}

/// Miss ratios of the machine's caches, by class: counted in the replay, and from reuse distances for caches without
/// sets and with random sets.
pub(crate) fn grid(summary: &ReuseSummary) -> Grid {
    let head = ["cache", "class", "each", "accesses", "misses", "without sets", "random sets", "first touches"];
    let mut rows = Vec::new();
    for level in &summary.levels {
        let each = format!("{}, {} ways", size(level.bytes), level.ways);
        for (class, curve) in &level.classes {
            let counts = summary.stats.caches.get(&level.name).and_then(|classes| classes.get(class));
            let share = |misses: f64| percent(misses / curve.sampled.max(1.0));
            let place = ReuseCurve::sizes().position(|size| size == level.bytes);
            rows.push(vec![
                level.name.clone(),
                class.name().into(),
                each.clone(),
                exact(curve.accesses),
                counts.map_or_else(String::new, |it| percent(it.misses as f64 / it.accesses.max(1) as f64)),
                place.map_or_else(String::new, |place| share(curve.misses[place])),
                share(curve.misses_in_sets),
                share(curve.first_touches),
            ]);
        }
    }
    Grid { head: head.map(String::from).to_vec(), names: 3, rows }
}
