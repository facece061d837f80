//! The content of a report on speed against accuracy.

use super::data::ParetoSummary;
use super::timing::Timing;

/// Results and times of every fidelity level.
pub(crate) struct ParetoReport {
    /// The results of every level.
    pub summary: ParetoSummary,
    /// Times of the truth, then of each level.
    pub timings: Vec<Timing>,
}
