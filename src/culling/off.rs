//! No culling.

use super::policy::{Policy, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::Ray;
use crate::quantity::LightId;

/// Keeps no state and traces every ray.
pub(crate) struct Off;

impl Policy for Off {
    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(Off)
    }
}

impl Worker for Off {
    fn decide(&mut self, _: SurfaceHit, _: LightId, _: &Ray, _: &mut Probe<'_>) -> Verdict {
        Verdict::Trace
    }
}
