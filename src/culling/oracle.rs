//! The limit of culling: every static answer known in advance, at no cost.

use super::policy::{Policy, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::Ray;
use crate::quantity::LightId;

/// Knows for every ray whether a static triangle blocks it.
pub(crate) struct Oracle;

impl Policy for Oracle {
    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(Oracle)
    }
}

impl Worker for Oracle {
    fn decide(&mut self, _: SurfaceHit, _: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict {
        if probe.statically_blocked(ray) { Verdict::Dark } else { Verdict::DynamicOnly }
    }
}
