//! How far a run's figures may be from the truth, and what a model needs.

use serde::{Deserialize, Serialize};

use crate::quantity::{Bytes, Cycle};

/// From the least to the most, both included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Range<T> {
    /// It cannot be less.
    pub least: T,
    /// It cannot be more.
    pub most: T,
}

/// What no machine of the spec can leave on the stream, whatever it does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bounds {
    /// Cycles: the least is the largest of what its parts must do over what they can do a cycle, the most is everything
    /// missed and one thing after another.
    pub cycles: Range<Cycle>,
    /// Bytes between the L1s and the L2: the least is every line once a kind of units.
    pub l2_bytes: Range<Bytes>,
    /// Bytes between the L2 and the DRAM: the least is every line once.
    pub dram_bytes: Range<Bytes>,
}

/// What could not be beaten if the answers of all shadow rays were known for nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limit {
    /// Cycles.
    pub cycles: Cycle,
    /// Bytes of the DRAM.
    pub dram_bytes: Bytes,
}

/// How far a run's numbers may be from those of `Event` and `Cycle`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// They are those.
    #[default]
    Exact,
    /// The truth lies within an interval with a probability of 95 %; the shares are half its width over the estimate.
    Estimated {
        /// Of the cycles.
        cycles: f64,
        /// Of the bytes between the L1s and the L2.
        l2_bytes: f64,
        /// Of the bytes of the DRAM.
        dram_bytes: f64,
        /// Share of the windows that were measured.
        rate: f64,
    },
    /// Nothing is known: a sample of so few windows tells nothing about itself.
    Few {
        /// Windows that were measured.
        windows: usize,
        /// From how many on it would.
        telling: usize,
    },
    /// Nothing is known but that the truth lies within [`super::MachineStats::bounds`].
    Bounded,
    /// Nothing is known.
    Unknown,
}

impl Accuracy {
    /// Half the widths of the intervals of cycles, L2 and DRAM bytes over the figures, where they are known.
    pub fn shares(&self) -> Option<[f64; 3]> {
        match *self {
            Self::Exact => Some([0.0; 3]),
            Self::Estimated { cycles, l2_bytes, dram_bytes, .. } => Some([cycles, l2_bytes, dram_bytes]),
            Self::Few { .. } | Self::Bounded | Self::Unknown => None,
        }
    }

    /// Half the width of the interval of a figure's ratio to what it was before, if samples tell both; `figure` is its
    /// place in [`Accuracy::shares`]. At worst their errors add up, since the samples are of different rays.
    pub fn of_ratio(&self, before: &Self, figure: usize, ratio: f64) -> Option<f64> {
        let share = self.shares()?[figure] + before.shares()?[figure];
        (*self != Self::Exact || *before != Self::Exact).then_some(ratio * share)
    }

    /// The largest of the shares, if they are known.
    pub fn widest(&self) -> Option<f64> {
        self.shares().map(|shares| shares.into_iter().fold(0.0, f64::max))
    }

    /// Whether all shares that are known are at most `target`, and nothing else is known to be off.
    pub fn is_within(&self, target: f64) -> bool {
        self.widest().is_some_and(|widest| widest <= target)
    }
}

/// What a stream needs of a machine's model, as a pilot found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Needs {
    /// The error that was asked for.
    pub target: f64,
    /// Share of the pixels in the pilot; as many were held back.
    pub pilot_share: f64,
    /// What each part that can be left out is worth.
    pub parts: Vec<PartNeed>,
    /// The models that were tried, the cheapest first; the last is the one that was taken.
    pub models: Vec<ModelCheck>,
}

/// What a part of the machine is worth: the pilot's figures change by these shares without it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartNeed {
    /// The part.
    pub part: String,
    /// Cycles.
    pub cycles: Option<f64>,
    /// Bytes between L1s and L2.
    pub l2_bytes: Option<f64>,
    /// DRAM bytes.
    pub dram_bytes: Option<f64>,
    /// Whether it matters: rungs below a sample have no parts that do not.
    pub matters: bool,
}

/// How a model did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelCheck {
    /// The model.
    pub model: String,
    /// The largest error of its cycles and bytes on the pilot; of a sample, half its widest interval.
    pub error: Option<f64>,
    /// The same on what was held back.
    pub held_back: Option<f64>,
    /// Whether it will do.
    pub passes: bool,
}
