//! All that a report on speed against accuracy is made of.

use super::data::ParetoSummary;
use super::timing::Timing;

/// What every level found, and how long each took.
pub(crate) struct ParetoReport {
    /// What every level found.
    pub summary: ParetoSummary,
    /// Of the truth, then of each level.
    pub timings: Vec<Timing>,
}
