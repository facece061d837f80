//! How far a run's figures may be from the truth.

use serde::{Deserialize, Serialize};

use crate::quantity::{Bytes, Cycle};

/// A closed range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Range<T> {
    /// The lower bound.
    pub least: T,
    /// The upper bound.
    pub most: T,
}

/// Bounds that no machine of the spec can leave on the stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bounds {
    /// Cycles. The lower bound is the largest of the parts' work over their throughput; the upper bound has only
    /// misses, and no two things at once.
    pub cycles: Range<Cycle>,
    /// Bytes between L1s and L2; the lower bound is each line once for each kind of units.
    pub l2_bytes: Range<Bytes>,
    /// Bytes between L2 and DRAM; the lower bound is each line once.
    pub dram_bytes: Range<Bytes>,
}

/// Lower bounds if the answers of all shadow rays were known at no cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limit {
    /// Cycles.
    pub cycles: Cycle,
    /// Bytes of the DRAM.
    pub dram_bytes: Bytes,
}

/// How far a run's figures may be from those of `Event` and `Cycle`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// They are equal.
    #[default]
    Exact,
    /// The truth lies within an interval with a probability of 95 %; the shares are relative half widths.
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
    /// The truth lies within [`super::MachineStats::bounds`]; nothing else is known.
    Bounded,
    /// Nothing is known.
    Unknown,
}

impl Accuracy {
    /// Relative half widths of the intervals of cycles, L2 and DRAM bytes, where they are known.
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
