//! What a stream asks of machines, from one pass: what each resource of any machine like the one of the pass is asked
//! for, without a replay of its own.
//!
//! The pass is a replay by [`super::Level::Profile`] that watches reuse distances. Misses of caches of any size and any
//! number of ways are read from them; what each part of a machine is then asked for is counted against what it can do.
//! An [`Estimate`] is rough: its errors are what a surrogate learns.

mod distances;
mod estimate;
mod watch;

use self::distances::Distances;
pub use self::estimate::Estimate;
use self::watch::Asked;
use super::error::RunError;
use super::items::Source;
use super::profile::Profile;
use super::whole::within_bounds;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::stats::{MachineStats, TrafficClass};
use crate::stream::{Header, Structure};

/// What a stream asks of machines.
#[derive(Clone, Debug)]
pub struct Demand {
    /// The machine of the pass.
    reference: MachineSpec,
    structure: Structure,
    /// What the pass measured.
    stats: MachineStats,
    /// Reuse in the L1s of each kind, all units together, by class.
    l1: [[Distances; TrafficClass::ALL.len()]; Kind::ALL.len()],
    /// Reuse of what a core asks for, whatever its L1s hold, by class.
    core: [Distances; TrafficClass::ALL.len()],
}

/// What a stream asks of machines like `machine`.
///
/// # Errors
/// The stream cannot be read, or a law that every run keeps is violated.
pub(crate) fn demand(machine: &MachineSpec, header: &Header, source: &dyn Source) -> Result<Demand, RunError> {
    let mut engine = Profile::watched(machine, header, Asked::new(machine, header));
    let mut items = source.open(0)?;
    let stats = within_bounds(&mut engine, machine, header, &mut items, None)?;
    let Asked { l1, core, .. } = engine.into_watch();
    Ok(Demand { reference: machine.clone(), structure: header.structure, stats, l1, core })
}
