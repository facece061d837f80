//! How long fidelity levels took. Times differ from run to run, and lie apart from all that does not.

use serde::{Deserialize, Serialize};

/// How long a rung took for all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Timing {
    /// The rung.
    pub rung: String,
    /// Wall time of the runs that it did not refuse, reading of the streams included.
    pub seconds: f64,
    /// That of the truth for the same runs.
    pub truth_seconds: f64,
    /// Rays of their streams.
    pub rays: u64,
}

impl Timing {
    /// A run that took so long, and the truth for it, on a stream of so many rays.
    pub(crate) fn add(&mut self, seconds: f64, truth_seconds: f64, rays: u64) {
        self.seconds += seconds;
        self.truth_seconds += truth_seconds;
        self.rays += rays;
    }

    /// Rays of the stream a second of wall time; none if all runs were refused.
    pub(crate) fn speed(&self) -> Option<f64> {
        (self.rays > 0).then(|| self.rays as f64 / self.seconds.max(1e-9))
    }

    /// How many times as fast as the truth it was.
    pub(crate) fn times(&self) -> Option<f64> {
        (self.rays > 0).then(|| self.truth_seconds / self.seconds.max(1e-9))
    }
}
