//! The figures of fidelity levels for a run, with those of the truth.

use serde::{Deserialize, Serialize};

use crate::stats::{Accuracy, MachineStats, Residuals};

/// A machine on the stream of a policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    /// The scene.
    pub scene: String,
    /// The machine.
    pub machine: String,
    /// The machine's clock in MHz.
    pub clock_mhz: u64,
    /// The policy.
    pub policy: String,
    /// Whether savings are measured against this policy.
    pub is_baseline: bool,
    /// The figures of the truth.
    pub truth: Figures,
    /// The result of each level.
    pub rungs: Vec<Found>,
}

/// The result of a level for a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum Found {
    /// The run was replayed.
    Measured(Measured),
    /// The level refused the run.
    Refused {
        /// The reason.
        refused: String,
    },
}

impl Run {
    /// The figures of level number `rung`, unless it refused the run.
    pub(super) fn found(&self, rung: usize) -> Option<&Measured> {
        match &self.rungs[rung] {
            Found::Measured(measured) => Some(measured),
            Found::Refused { .. } => None,
        }
    }
}

/// The figures that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// Cycles.
    pub cycles: u64,
    /// Bytes between L1s and L2.
    pub l2_bytes: u64,
    /// Bytes of the DRAM.
    pub dram_bytes: u64,
}

impl Figures {
    /// From a run's statistics.
    pub(crate) fn of(stats: &MachineStats) -> Self {
        let l2 = stats.bytes.keys().filter(|level| level.starts_with("l2"));
        Self {
            cycles: stats.cycles.0,
            l2_bytes: l2.map(|level| stats.moved(level).0).sum(),
            dram_bytes: stats.moved("dram").0,
        }
    }

    /// All figures, in the order of the fields.
    pub(super) fn all(self) -> [f64; 3] {
        [self.cycles, self.l2_bytes, self.dram_bytes].map(|figure| figure as f64)
    }
}

/// The figures of a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Measured {
    /// The figures.
    #[serde(flatten)]
    pub figures: Figures,
    /// The error that the level claims.
    pub accuracy: Accuracy,
    /// The residuals of its windows, if it is a sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residuals: Option<Residuals>,
}

impl Measured {
    /// From a run's statistics.
    pub(crate) fn of(stats: MachineStats) -> Self {
        Self { figures: Figures::of(&stats), accuracy: stats.accuracy, residuals: stats.residuals }
    }

    /// The data on its error: what it claims, and the residuals of a sample.
    pub(super) fn trust(&self) -> (&Accuracy, Option<&Residuals>) {
        (&self.accuracy, self.residuals.as_ref())
    }

    /// Half the widths of its intervals, as shares of the figures; `None` for exact figures.
    pub(super) fn claimed(&self) -> Option<[f64; 3]> {
        self.accuracy.shares().filter(|_| self.accuracy != Accuracy::Exact)
    }
}
