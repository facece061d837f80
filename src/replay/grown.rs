//! Energy of a large machine that a scale model represents.

use crate::energy;
use crate::machine::MachineSpec;
use crate::quantity::{Bytes, Cycle};
use crate::stats::{CacheCounts, DramCounts, Energy, MachineStats};
use crate::stream::Structure;

/// Energy of the `large` machine, if all counts are `times` those of its `model`, and the time is `longer` times the
/// model's. `None` where the DRAM's energy is not known.
pub(crate) fn energy_by_model(
    large: &MachineSpec,
    structure: Structure,
    model: &MachineStats,
    times: f64,
    longer: f64,
) -> Option<Energy> {
    energy::of(large, structure, &grown(model, times, longer))
}

/// The counts that determine energy, multiplied by `times`. Time and refreshes, which depend on it, are multiplied by
/// `longer`: a model has as many channels as the large machine.
fn grown(stats: &MachineStats, times: f64, longer: f64) -> MachineStats {
    let mut large = stats.clone();
    let by = |count: u64, factor: f64| (count as f64 * factor).round() as u64;
    large.cycles = Cycle(by(stats.cycles.0, longer));
    large.rays = by(stats.rays, times);
    large.operations.values_mut().for_each(|count| *count = by(*count, times));
    for bytes in large.bytes.values_mut().flat_map(|level| level.values_mut()) {
        *bytes = Bytes(by(bytes.0, times));
    }
    for cache in large.caches.values_mut().flat_map(|level| level.values_mut()) {
        cache.counts = CacheCounts::from_values(cache.counts.values().map(|count| by(count, times)));
    }
    let refreshes = by(stats.dram.refreshes, longer);
    large.dram = DramCounts { refreshes, ..DramCounts::from_values(stats.dram.values().map(|count| by(count, times))) };
    large
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_grow_with_the_cores_and_refreshes_with_the_time() {
        let mut model = MachineStats { cycles: Cycle(1000), rays: 10, ..MachineStats::default() };
        model.dram = DramCounts { reads: 100, activates: 50, refreshes: 8, ..DramCounts::default() };
        model.operations.insert("traversal".into(), 30);
        let large = grown(&model, 8.0, 1.25);
        assert_eq!((large.cycles, large.rays, large.operations["traversal"]), (Cycle(1250), 80, 240));
        let expected = DramCounts { reads: 800, activates: 400, refreshes: 10, ..DramCounts::default() };
        assert_eq!(large.dram, expected);
    }
}
