//! What is known of every design for nearly nothing: from few passes over each stream.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::super::progress::Progress;
use super::super::sweep::{Point, Recorded, Sweep, SweepError, estimates as passes};
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::replay::Estimate;

/// The most passes over a stream for a machine of the experiment. With more, one must do for all.
const MOST: usize = 8;

/// Which fields of a machine the machine of its pass has too, beside those that a pass must know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shared {
    /// Those that say in which order accesses come: numbers of units, and of rays in them.
    Order,
    /// The number of traversal units, which says the most of the order.
    Traversal,
    /// None.
    Nothing,
}

/// The machine of the pass that tells of `machine`: as that one is where a pass must know it, such as the size of
/// lines, the places of words and what the host moves, and where fields are `shared`; and as the experiment's machine
/// `base` in what an estimate works out, such as sizes and times.
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
    // Sizes of the one may not fit lines of the other.
    if reference.check().is_ok() { reference } else { MachineSpec { name: base.name.clone(), ..machine.clone() } }
}

/// The machines of the passes that tell of `machines`, and of each machine the place of its own among them: as few as
/// [`MOST`], so that their fields are shared as far as that allows.
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

/// Estimates of all `points`, which are of one machine of the experiment under one policy, and how many passes over the
/// stream these took; passes that are kept in a folder are not made again.
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
        assert_eq!(found.len(), of_pass.len(), "a pass estimates each of its machines");
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
