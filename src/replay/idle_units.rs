//! Machines that differ in shadow-cache units alone, on a stream that gives these units nothing to do.

use crate::energy;
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::Place;
use crate::stats::MachineStats;
use crate::stream::{Header, StoreEntries};

/// Whether a stream without policy steps gives the shadow-cache units of `machine` nothing to do. A coalescing register
/// is written out at every end of frame, even where it is empty. That takes a cycle, after which the next frame meets
/// the DRAM's refreshes at other times.
pub(crate) fn are_units_idle(machine: &MachineSpec) -> bool {
    let unit = &machine.shadow_cache;
    unit.register.get() == 0 || unit.place == Place::Free
}

/// The statistics of `machine` on a stream without policy steps, from those of a machine with idle shadow-cache units
/// that differs in these alone. Without stores the scene lies at the same addresses, so only the energy differs.
/// Bounds, the energy of frames and the units' own counts stay those of the replayed machine. A sample stays the one
/// of that machine too: the units' options choose covariates, so another sample would differ within its interval.
///
/// # Panics
/// If the units have something to do.
pub(crate) fn with_other_units(machine: &MachineSpec, header: &Header, stats: &MachineStats) -> MachineStats {
    let operations = stats.operations.get("shadow_cache").copied().unwrap_or(0);
    let nothing = (StoreEntries::default(), 0);
    assert_eq!((header.stores, operations), nothing, "the stream gives shadow-cache units nothing to do");
    let energy = stats.energy.as_ref().and_then(|_| energy::of(machine, header.structure, stats));
    MachineStats { energy, ..stats.clone() }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::engine::tests::agreement::check_many;
    use crate::engine::tests::frames::numbered;
    use crate::engine::tests::num;
    use crate::engine::tests::random::{machines, streams};
    use crate::machine::shadow_cache::ShadowCacheSpec;
    use crate::replay::{Level, OnePass, Replay};
    use crate::stream::{Chunk, Decision, Item, RayHead, Totals};

    /// The same paths without policy: all rays are traced.
    fn without_policy(stream: &[Item]) -> Vec<Item> {
        let mut totals = Totals::default();
        let item = |item: &Item| match item {
            Item::Frame(info) => Item::Frame(*info),
            Item::Rays(chunk) => {
                let mut plain = Chunk::default();
                for ray in chunk.rays() {
                    let head = RayHead { decision: Decision::Trace, ..ray.head };
                    plain.push(head, ray.packed_path(), &[]);
                }
                plain.rays().for_each(|ray| totals.count(&ray));
                Item::Rays(Arc::new(plain))
            }
            Item::End { .. } => Item::End { policy: Arc::default(), totals: std::mem::take(&mut totals) },
        };
        stream.iter().map(item).collect()
    }

    /// Statistics without the units' own, which bounds allow for.
    fn of_others(mut stats: MachineStats) -> MachineStats {
        let unit = |name: &String| !name.contains("shadow_cache");
        stats.units.retain(|name, _| unit(name));
        stats.unit_counts.retain(|name, _| unit(name));
        stats.frames.clear();
        MachineStats { bounds: None, ..stats }
    }

    #[test]
    fn idle_units_change_nothing_but_energy() {
        check_many(
            200,
            || (machines(), streams(), 0..2u32),
            |(mut machine, stream, warmup)| {
                if !are_units_idle(&machine) {
                    machine.shadow_cache.register = num(0);
                }
                let (header, stream) = numbered(&without_policy(&stream), warmup);
                let header = Header { stores: StoreEntries::default(), ..header };
                let other = MachineSpec { shadow_cache: ShadowCacheSpec::default(), ..machine.clone() };
                for level in [Level::Event, Level::Profile].map(OnePass::Whole) {
                    let measured = |machine: &MachineSpec| {
                        let replay = Replay::new(machine, &header).map_err(|error| error.to_string())?;
                        let stats = replay.fidelity(level).run(stream.iter().cloned().map(Ok));
                        stats.map_err(|error| error.to_string())
                    };
                    let [with, without] = [measured(&machine)?, measured(&other)?];
                    let derived = with_other_units(&other, &header, &with);
                    let joules = |stats: &MachineStats| stats.energy.as_ref().map_or(0.0, |energy| energy.joules);
                    let [derived_joules, joules] = [joules(&derived), joules(&without)];
                    if (derived_joules / joules - 1.0).abs() > 1e-9 {
                        return Err(format!("{derived_joules} J in place of {joules} J"));
                    }
                    let energy = without.energy.clone();
                    let derived = of_others(MachineStats { energy, ..derived });
                    let without = of_others(without);
                    if derived != without {
                        return Err(format!("{derived:?}\nin place of\n{without:?}"));
                    }
                }
                Ok(())
            },
        );
    }
}
