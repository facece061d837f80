//! No culling, but another order of visits: shadow rays visit the child with the larger box first (SATO: Nah and
//! Manocha 2014), because a blocker is more likely there.

use super::policy::{Policy, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::{Order, Ray};
use crate::quantity::LightId;

/// Keeps no state and traces every ray, in its own order.
pub(crate) struct Sato;

impl Policy for Sato {
    fn order(&self) -> Order {
        Order::LargestFirst
    }

    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(Sato)
    }
}

impl Worker for Sato {
    fn decide(&mut self, _: SurfaceHit, _: LightId, _: &Ray, _: &mut Probe<'_>) -> Verdict {
        Verdict::Trace
    }
}
