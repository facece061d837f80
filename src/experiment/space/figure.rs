//! Figures that designs are compared by.

use crate::replay::Estimate;
use crate::stats::MachineStats;

/// Lower limit of a figure before its logarithm is taken.
pub(super) const LEAST: f64 = 1e-30;

/// A figure that designs are compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Figure {
    Cycles,
    DramBytes,
    Joules,
}

impl Figure {
    pub(super) const ALL: [Self; 3] = [Self::Cycles, Self::DramBytes, Self::Joules];

    /// The figure's name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Cycles => "cycles",
            Self::DramBytes => "dram_bytes",
            Self::Joules => "joules",
        }
    }

    /// The measured value; `None` if the energy is not known.
    pub(super) fn measured(self, stats: &MachineStats) -> Option<f64> {
        match self {
            Self::Cycles => Some(stats.cycles.0 as f64),
            Self::DramBytes => Some(stats.moved("dram").0 as f64),
            Self::Joules => stats.energy.as_ref().map(|energy| energy.joules),
        }
    }

    /// The estimated value; 1 if the energy is not known.
    pub(super) fn estimated(self, estimate: &Estimate) -> f64 {
        match self {
            Self::Cycles => estimate.cycles,
            Self::DramBytes => estimate.dram_bytes,
            Self::Joules => estimate.joules.unwrap_or(1.0),
        }
    }
}
