//! What is known of every design for nearly nothing: from few passes over each stream.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::super::sweep::{Point, Recorded, Sweep, SweepError, demand};
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::replay::{Demand, Estimate};

/// The most passes over a stream for a machine of the experiment. With more, one must do for all.
const MOST: usize = 8;

/// The machine of the pass that tells of `machine`: as that one is where a pass must know it, such as the size of
/// lines, the places of words and what the host moves; and as the experiment's machine `base` in what an estimate works
/// out, such as sizes, numbers and times.
fn reference(machine: &MachineSpec, base: &MachineSpec) -> MachineSpec {
    let ShadowCacheSpec { count, latency, interval, contexts, width, cache, .. } = base.shadow_cache;
    let unit = ShadowCacheSpec { count, latency, interval, contexts, width, cache, ..machine.shadow_cache };
    let MachineSpec { line_bytes, cores, traffic, .. } = *machine;
    let reference = MachineSpec { line_bytes, cores, traffic, shadow_cache: unit, ..base.clone() };
    // Sizes of the one may not fit lines of the other.
    if reference.check().is_ok() { reference } else { MachineSpec { name: base.name.clone(), ..machine.clone() } }
}

/// Estimates of all `points`, which are of one machine of the experiment under one policy, and how many passes over the
/// stream these took; passes that are kept in a folder are not made again.
///
/// # Errors
/// A pass fails, or `stop` was set.
pub(super) fn estimates(
    sweep: &Sweep,
    stream: &Recorded,
    points: &[Point],
    (folder, stop): (&Path, &AtomicBool),
) -> Result<(Vec<Estimate>, usize), SweepError> {
    let machine = |point: &Point| Ok::<_, SweepError>(point.role.machine(&sweep.machine(point.machine)?.spec));
    let machines: Vec<MachineSpec> = points.iter().map(machine).collect::<Result<_, _>>()?;
    let base = points.first().and_then(|point| {
        let (_, base) = sweep.experiment.machines.iter().nth(sweep.base(point.machine))?;
        Some(point.role.machine(base))
    });
    let Some(base) = base else { return Ok((Vec::new(), 0)) };
    let mut references: Vec<MachineSpec> = Vec::new();
    let mut of_machine = Vec::new();
    for machine in &machines {
        let reference = reference(machine, &base);
        let place = references.iter().position(|other| *other == reference).unwrap_or_else(|| {
            references.push(reference);
            references.len() - 1
        });
        of_machine.push(place);
    }
    if references.len() > MOST {
        references = vec![base];
        of_machine.fill(0);
    }
    let demands = references.par_iter().map(|machine| demand(machine, stream, folder, stop));
    let demands: Vec<Demand> = demands.collect::<Result<_, _>>()?;
    let estimates = machines.par_iter().zip(&of_machine).map(|(machine, &of)| demands[of].estimate(machine)).collect();
    Ok((estimates, demands.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::set;

    #[test]
    fn machines_that_differ_in_sizes_and_numbers_share_a_pass() {
        let base = MachineSpec::default();
        let with = |path: &str, value: &str| set::field(&base, path, value).unwrap();
        for (path, value) in [("l2.bytes", "65536"), ("traversal.count", "3"), ("shadow_cache.cache.ways", "4")] {
            assert_eq!(reference(&with(path, value), &base), base, "{path}");
        }
        for (path, value) in [("shadow_cache.place", "L2"), ("line_bytes", "128"), ("traffic.rays", "Dram")] {
            assert_eq!(reference(&with(path, value), &base), with(path, value), "{path}");
        }
    }
}
