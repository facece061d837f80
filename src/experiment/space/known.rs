//! Estimates of every design at little cost: from few passes over each stream.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::super::progress::Progress;
use super::super::sweep::{Point, Recorded, Sweep, SweepError, estimates as passes};
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::replay::Estimate;

/// The most passes over a stream for each machine of the experiment. If more are needed without any shared field, one
/// pass serves all. Assumed.
const MOST: usize = 8;

/// Which fields a machine shares with the machine of its pass, besides those that every pass needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shared {
    /// The fields that set the order of accesses: numbers of units, and of the rays in them.
    Order,
    /// The number of traversal units, which affects the order most.
    Traversal,
    /// No further field.
    Nothing,
}

/// The machine of the pass that estimates `machine`. It has `machine`'s values where every pass needs them (line size,
/// layout of mode words, the host's traffic) and in the `shared` fields. It has `base`'s values in fields whose effect
/// an estimate computes, such as sizes and latencies.
fn reference(machine: &MachineSpec, base: &MachineSpec, shared: Shared) -> MachineSpec {
    let ShadowCacheSpec { count, latency, interval, contexts, width, cache, .. } = base.shadow_cache;
    let unit = ShadowCacheSpec { count, latency, interval, contexts, width, cache, ..machine.shadow_cache };
    let MachineSpec { line_bytes, cores, traffic, .. } = *machine;
    let mut reference = MachineSpec { line_bytes, cores, traffic, shadow_cache: unit, ..base.clone() };
    if shared != Shared::Nothing {
        reference.traversal.count = machine.traversal.count;
    }
    if shared == Shared::Order {
        reference.traversal.rays = machine.traversal.rays;
        reference.dispatcher.rays = machine.dispatcher.rays;
        reference.list.count = machine.list.count;
        reference.intersection.count = machine.intersection.count;
        reference.shadow_cache.count = machine.shadow_cache.count;
    }
    // Sizes of `base` may not fit the line size of `machine`.
    if reference.check().is_ok() { reference } else { MachineSpec { name: base.name.clone(), ..machine.clone() } }
}

/// The machines of the passes that estimate `machines`, and for each machine the index of its pass. Shares the most
/// fields that need no more than [`MOST`] passes.
fn references(machines: &[MachineSpec], base: &MachineSpec) -> (Vec<MachineSpec>, Vec<usize>) {
    for shared in [Shared::Order, Shared::Traversal, Shared::Nothing] {
        let mut references: Vec<MachineSpec> = Vec::new();
        let place = |machine| {
            let reference = reference(machine, base, shared);
            references.iter().position(|other| *other == reference).unwrap_or_else(|| {
                references.push(reference);
                references.len() - 1
            })
        };
        let places = machines.iter().map(place).collect();
        if references.len() <= MOST {
            return (references, places);
        }
    }
    (vec![base.clone()], vec![0; machines.len()])
}

/// Estimates all `points`, which belong to one machine of the experiment under one policy. Returns also the number of
/// passes over the stream. Passes that are kept in the folder are not made again.
///
/// # Errors
/// A pass fails, or `stop` was set.
pub(super) fn estimates(
    sweep: &Sweep,
    stream: &Recorded,
    points: &[Point],
    kept: (&Path, &AtomicBool),
    bar: &Progress,
) -> Result<(Vec<Estimate>, usize), SweepError> {
    let machine = |point: &Point| Ok::<_, SweepError>(point.role.machine(&sweep.machine(point.machine)?.spec));
    let machines: Vec<MachineSpec> = points.iter().map(machine).collect::<Result<_, _>>()?;
    let base = points.first().and_then(|point| {
        let (_, base) = sweep.experiment.machines.iter().nth(sweep.base(point.machine))?;
        Some(point.role.machine(base))
    });
    let Some(base) = base else { return Ok((Vec::new(), 0)) };
    let (references, of_machine) = references(&machines, &base);
    let found = references.par_iter().enumerate().map(|(place, reference)| {
        let of_pass = machines.iter().zip(&of_machine).filter(|(_, of)| **of == place);
        let of_pass: Vec<MachineSpec> = of_pass.map(|(machine, _)| machine.clone()).collect();
        let found = passes(reference, &of_pass, stream, kept)?;
        bar.inc(found.len() as u64);
        Ok(found.into_iter())
    });
    let mut found = found.collect::<Result<Vec<_>, SweepError>>()?;
    let estimates = of_machine.iter().map(|&of| found[of].next().expect("a pass estimates each of its machines"));
    let estimates = estimates.collect();
    Ok((estimates, references.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::set;

    fn with(base: &MachineSpec, path: &str, value: &str) -> MachineSpec {
        set::field(base, path, value).unwrap()
    }

    #[test]
    fn machines_that_differ_in_sizes_and_times_share_a_pass() {
        let base = MachineSpec::default();
        for (path, value) in [("l2.bytes", "65536"), ("traversal.latency", "3"), ("shadow_cache.cache.ways", "4")] {
            assert_eq!(reference(&with(&base, path, value), &base, Shared::Order), base, "{path}");
        }
        for (path, value) in [("shadow_cache.place", "L2"), ("line_bytes", "128"), ("traffic.rays", "Dram")] {
            let own = with(&base, path, value);
            assert_eq!(reference(&own, &base, Shared::Nothing), own, "{path}");
        }
    }

    #[test]
    fn fields_are_shared_as_far_as_there_are_few_passes() {
        let base = MachineSpec::default();
        let machines = |counts: std::ops::RangeInclusive<u64>| -> Vec<MachineSpec> {
            let of = |count: u64| with(&base, "traversal.count", &count.to_string());
            let all = counts.flat_map(|count| [1, 2].map(|tests| (of(count), tests)));
            all.map(|(machine, tests)| with(&machine, "intersection.count", &tests.to_string())).collect()
        };
        assert_eq!(references(&machines(1..=4), &base).0.len(), 8, "a pass for each number of both");
        let (found, places) = references(&machines(1..=5), &base);
        assert_eq!((found.len(), places), (5, vec![0, 0, 1, 1, 2, 2, 3, 3, 4, 4]), "of traversal units");
        assert_eq!(references(&machines(1..=9), &base).0, std::slice::from_ref(&base));
    }
}
