//! The longest time that a machine may make no progress.

use crate::machine::MachineSpec;
use crate::memory::dram::spec::Model;

/// The watchdog's limit, in cycles: longer than any single wait of the machine, or two waits in a row,
/// except for the building of a frame, which the engines add (rule H6).
pub(crate) fn patience(spec: &MachineSpec) -> u64 {
    let caches = spec.l2.caches();
    let l2 = caches.iter().map(|(_, cache)| cache.latency.get());
    let units = [
        spec.dispatcher.latency.get(),
        spec.dispatcher.shading_cycles.get(),
        spec.traversal.latency.get(),
        spec.list.latency.get(),
        spec.intersection.latency.get(),
        spec.division.latency.get(),
        spec.shadow_cache.latency.get(),
        l2.max().unwrap_or(0),
    ];
    let part = &spec.dram.part;
    let dram = match spec.dram.model {
        Model::Banks => {
            let clocks = part.timing.around_refresh(part.burst_clocks.get()) + part.timing.cl.get();
            spec.dram.clocks(spec.clock_mhz.get()).cycle_after(clocks)
        }
        Model::Flat { latency, .. } => latency.get(),
    };
    100_000 + 2 * units.iter().sum::<u64>() + 2 * dram
}
