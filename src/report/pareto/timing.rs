//! Times of fidelity levels. Times differ from run to run, so they are kept apart from all numbers that do not.

use serde::{Deserialize, Serialize};

/// The time of a level for all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Timing {
    /// The level.
    pub rung: String,
    /// Wall time of the runs that it did not refuse, including the time to read the streams.
    pub seconds: f64,
    /// Wall time of the truth for the same runs.
    pub truth_seconds: f64,
    /// Rays of their streams.
    pub rays: u64,
}

impl Timing {
    /// Adds a run: its wall time, the truth's wall time, and the rays of its stream.
    pub(crate) fn add(&mut self, seconds: f64, truth_seconds: f64, rays: u64) {
        self.seconds += seconds;
        self.truth_seconds += truth_seconds;
        self.rays += rays;
    }

    /// Rays of the stream per second of wall time; `None` if all runs were refused.
    pub(crate) fn speed(&self) -> Option<f64> {
        (self.rays > 0).then(|| self.rays as f64 / self.seconds.max(1e-9))
    }

    /// The level's speed as a multiple of the truth's.
    pub(crate) fn times(&self) -> Option<f64> {
        (self.rays > 0).then(|| self.truth_seconds / self.seconds.max(1e-9))
    }
}
