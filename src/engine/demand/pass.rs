//! The passes.

use super::caches::{Caches, bytes};
use super::estimate::{Demand, Estimate};
use crate::engine::error::RunError;
use crate::engine::items::Source;
use crate::engine::profile::Profile;
use crate::engine::whole::within_bounds;
use crate::machine::MachineSpec;
use crate::stream::Header;

/// Maximum memory in bytes of the tags in a pass, unless one machine alone needs more.
const MOST_BYTES: u64 = 1 << 28;

/// Rough estimates of each of `machines` for a stream, from passes on `reference`. The machines may differ from it in
/// sizes, numbers and times.
///
/// # Errors
/// The stream cannot be read, or violates a law that holds for every run.
pub(crate) fn estimates(
    reference: &MachineSpec,
    header: &Header,
    source: &dyn Source,
    machines: &[MachineSpec],
) -> Result<Vec<Estimate>, RunError> {
    let mut found = Vec::with_capacity(machines.len());
    let mut rest = machines;
    while !rest.is_empty() {
        let taken = rest.iter().scan(0, |all, machine| {
            *all += bytes(machine);
            Some(*all)
        });
        let (some, others) = rest.split_at(taken.take_while(|all| *all <= MOST_BYTES).count().max(1));
        let with_reference: Vec<&MachineSpec> = std::iter::once(reference).chain(some).collect();
        let mut engine = Profile::watched(reference, header, Caches::new(reference, header, &with_reference));
        let stats = within_bounds(&mut engine, reference, header, &mut source.open(0)?, None)?;
        let mut misses = engine.into_watch().finish().into_iter();
        let own = misses.next().unwrap_or_default();
        let demand = Demand { reference, structure: header.structure, stats, misses: own };
        found.extend(some.iter().zip(misses).map(|(machine, misses)| demand.estimate(machine, misses)));
        rest = others;
    }
    Ok(found)
}
