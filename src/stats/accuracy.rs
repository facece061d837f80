//! How far a run's figures may be from the truth.

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
            Self::Bounded | Self::Unknown => None,
        }
    }

    /// The largest of the shares, if they are known.
    pub fn widest(&self) -> Option<f64> {
        self.shares().map(|shares| shares.into_iter().fold(0.0, f64::max))
    }
}
