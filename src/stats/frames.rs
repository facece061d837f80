//! What was measured in one frame.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::counts::{CacheCounts, DramCounts};
use super::energy::Energy;
use super::traffic::Cause;
use crate::quantity::{Bytes, Cycle};

/// What a machine measured in one frame, all classes of traffic together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameStats {
    /// The frame's number.
    pub frame: u32,
    /// Whether the frame warms caches and words up and is left out of all sums.
    pub warmup: bool,
    /// From the end of the frame that was replayed before to the end of this one.
    pub cycles: Cycle,
    /// Rays replayed, skipped ones not counted.
    pub rays: u64,
    /// Rays that the frame asks for: those replayed and those skipped, whose answers are known.
    pub answered: u64,
    /// Bytes moved a level, as [`super::MachineStats::bytes`].
    pub bytes: BTreeMap<String, Bytes>,
    /// Accesses a cache.
    pub caches: BTreeMap<String, CacheCounts>,
    /// Cycles of every unit kind by cause.
    pub units: BTreeMap<String, BTreeMap<Cause, u64>>,
    /// The DRAM's commands.
    pub dram: DramCounts,
    /// Energy, as [`super::MachineStats::energy`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
}
