//! The pass, and what it found.

use serde::{Deserialize, Serialize};

use super::distances::Distances;
use super::watch::Asked;
use crate::engine::error::RunError;
use crate::engine::items::Source;
use crate::engine::profile::Profile;
use crate::engine::whole::within_bounds;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::stats::{MachineStats, TrafficClass};
use crate::stream::{Header, Structure};

/// What a stream asks of machines.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Demand {
    /// The machine of the pass.
    pub(super) reference: MachineSpec,
    pub(super) structure: Structure,
    /// What the pass measured.
    pub(super) stats: MachineStats,
    /// Reuse in the L1s of each kind, all units together, by class.
    pub(super) l1: [[Distances; TrafficClass::ALL.len()]; Kind::ALL.len()],
    /// Reuse of what a core asks for, whatever its L1s hold, by class.
    pub(super) core: [Distances; TrafficClass::ALL.len()],
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
