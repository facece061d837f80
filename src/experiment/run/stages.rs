//! Where a run's wall time goes.

use std::time::Duration;

use crate::named::Named;

/// Wall time of the stages that alternate, frame by frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clock {
    /// Time of the tracer.
    pub trace: Duration,
    /// Time of the reference renderer and of comparisons.
    pub reference: Duration,
    /// Time spent waiting for machines that are slower than the tracer.
    pub machines: Duration,
}

/// The stages of a run.
#[derive(Default)]
pub(super) struct Stages {
    /// Seconds of each stage.
    pub wall_seconds: Named<f64>,
    /// Rays a second, of the stages that have rays.
    pub speeds: Named<f64>,
}

impl Stages {
    /// Adds a stage that took `wall`, and the rays that it worked on.
    pub(super) fn add(&mut self, name: impl Into<String>, wall: Duration, rays: Option<u64>) {
        let name = name.into();
        if let Some(rays) = rays.filter(|_| !wall.is_zero()) {
            self.speeds.insert(name.as_str(), rays as f64 / wall.as_secs_f64());
        }
        self.wall_seconds.insert(name, wall.as_secs_f64());
    }
}
