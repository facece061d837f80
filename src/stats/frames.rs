//! The measurements of one frame.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::counts::{CacheCounts, DramCounts};
use super::energy::Energy;
use super::traffic::Cause;
use crate::quantity::{Bytes, Cycle};

/// The measurements of one frame, all classes of traffic together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameStats {
    /// The frame's number.
    pub frame: u32,
    /// Whether the frame only warms caches and mode words up, and is left out of all sums.
    pub warmup: bool,
    /// Cycles from the end of the frame replayed before to the end of this one.
    pub cycles: Cycle,
    /// Rays replayed, skipped ones not counted.
    pub rays: u64,
    /// Rays of the frame: traced rays, and skipped rays, whose answers are known.
    pub answered: u64,
    /// Bytes moved at each level, as [`super::MachineStats::bytes`].
    pub bytes: BTreeMap<String, Bytes>,
    /// Accesses of each kind of caches.
    pub caches: BTreeMap<String, CacheCounts>,
    /// Cycles of every unit kind by cause.
    pub units: BTreeMap<String, BTreeMap<Cause, u64>>,
    /// The DRAM's commands.
    pub dram: DramCounts,
    /// Energy, as [`super::MachineStats::energy`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
}
