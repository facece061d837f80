//! The scene at a frame, and its queries for rays.

use glam::DVec3;

use super::bvh::Tree;
use super::ray::Ray;
use crate::quantity::PrimitiveId;
use crate::scene::{Frame, Scene};

/// A scene at a frame, ready for rays.
pub struct ReferenceFrame<'a> {
    pub(super) scene: &'a Scene,
    pub(super) frame: &'a Frame,
    pub(super) statics: &'a Tree,
    pub(super) dynamic: Tree,
    /// The largest magnitude of a triangle's coordinate.
    pub(super) reach: f64,
}

/// Where a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position on the ray, in lengths of its direction.
    pub t: f64,
    /// The primitive that is hit.
    pub primitive: PrimitiveId,
    /// The weights of the triangle's corners at the hit point.
    pub weights: [f64; 3],
}

impl ReferenceFrame<'_> {
    /// The nearest hit with t > 0 of the ray from `origin` along `direction` (of any length).
    pub fn closest(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(origin, direction, f64::INFINITY, |hit| {
            if best.is_none_or(|best| (hit.t, hit.primitive) < (best.t, best.primitive)) {
                best = Some(hit);
            }
            best.map_or(f64::INFINITY, |best| best.t)
        });
        best
    }

    /// Whether any triangle meets the segment from `origin` to `target`, both ends excluded.
    pub fn occluded(&self, origin: DVec3, target: DVec3) -> bool {
        let mut blocked = false;
        self.walk(origin, target - origin, 1.0, |hit| {
            blocked |= hit.t < 1.0;
            if blocked { f64::NEG_INFINITY } else { 1.0 }
        });
        blocked
    }

    fn walk(&self, origin: DVec3, direction: DVec3, mut limit: f64, mut visit: impl FnMut(Hit) -> f64) {
        if !direction.is_finite() {
            return;
        }
        let ray = Ray::new(origin, direction, self.reach);
        for tree in [self.statics, &self.dynamic] {
            tree.walk(&ray, limit, |primitive, crossing| {
                limit = visit(Hit { t: crossing.t, primitive, weights: crossing.weights });
                limit
            });
        }
    }
}
