//! The triangle record and its test, in the phases of an intersection unit: plane, edges, division.

use glam::{Vec2, Vec3};

use super::Ray;
use crate::quantity::PrimitiveId;
use crate::scene::Triangle;
use crate::stream::Stop;

/// What the test reads of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    corner: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
    /// Whose record it is.
    pub primitive: PrimitiveId,
}

/// A hit on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric coordinates of corners 1 and 2.
    pub barycentric: Vec2,
}

/// Lets a hit at the very distance of the nearest one so far pass the plane test, whose product form rounds
/// differently from the quotient: the tie is settled later, on the quotient.
const TIE: f32 = 1.0 + 4.0 * f32::EPSILON;

impl Record {
    /// The record of `triangle`.
    pub fn new(triangle: &Triangle, primitive: PrimitiveId) -> Self {
        let [a, b, c] = triangle.v;
        let edges = [b - a, c - a];
        Self { corner: a, edges, normal: edges[0].cross(edges[1]), primitive }
    }

    /// Tests the triangle, both sides, for `0 < t <= ray.reach` (a little beyond, see `TIE`). Moeller-Trumbore with
    /// the normal at hand, so that the plane's part stands alone, as in the T&I engine's first mode (Nah et al. 2011,
    /// section 4.3).
    pub fn test(&self, ray: &Ray) -> (Stop, Option<TriangleHit>) {
        let towards = -ray.direction.dot(self.normal);
        let sign = 1.0f32.copysign(towards);
        let facing = towards.abs();
        let from_corner = ray.origin - self.corner;
        let distance = from_corner.dot(self.normal) * sign;
        // A degenerate triangle has a zero normal: nothing lies strictly between.
        if !(distance > 0.0 && distance <= facing * ray.reach * TIE) {
            return (Stop::Plane, None);
        }
        let moment = from_corner.cross(ray.direction);
        let u = self.edges[1].dot(moment) * sign;
        let v = -self.edges[0].dot(moment) * sign;
        if !(u >= 0.0 && v >= 0.0 && u + v <= facing) {
            return (Stop::Edges, None);
        }
        let scale = 1.0 / facing;
        (Stop::Hit, Some(TriangleHit { t: distance / facing, barycentric: Vec2::new(u * scale, v * scale) }))
    }

    /// Whether the triangle blocks the ray: a hit at `0 < t < ray.reach`.
    pub fn blocks(&self, ray: &Ray) -> (Stop, bool) {
        match self.test(ray) {
            (Stop::Hit, Some(hit)) if hit.t < ray.reach => (Stop::Hit, true),
            // Only just out of reach: the plane's part of the hardware, which compares without a tie rule, ends it.
            (Stop::Hit, _) => (Stop::Plane, false),
            (stop, _) => (stop, false),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> Record {
        let triangle = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        Record::new(&triangle, PrimitiveId(7))
    }

    #[test]
    fn hits_inside_from_both_sides() {
        for side in [1.0, -1.0] {
            let ray = Ray::new(Vec3::new(0.25, 0.5, 2.0 * side), Vec3::new(0.0, 0.0, -side), f32::INFINITY);
            let (stop, hit) = record().test(&ray);
            assert_eq!(stop, Stop::Hit);
            assert_eq!(hit, Some(TriangleHit { t: 2.0, barycentric: Vec2::new(0.25, 0.5) }));
        }
    }

    #[test]
    fn stops_at_the_plane_or_at_the_edges() {
        let behind = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::Z, f32::INFINITY);
        assert_eq!(record().test(&behind), (Stop::Plane, None));
        let short = Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z, 0.5);
        assert_eq!(record().test(&short), (Stop::Plane, None));
        let beside = Ray::new(Vec3::new(0.75, 0.75, 1.0), -Vec3::Z, f32::INFINITY);
        assert_eq!(record().test(&beside), (Stop::Edges, None));
        let parallel = Ray::new(Vec3::new(0.25, 0.25, 0.0), Vec3::X, f32::INFINITY);
        assert_eq!(record().test(&parallel), (Stop::Plane, None));
    }

    #[test]
    fn a_segment_is_open_at_both_ends() {
        let starts_on = Ray::segment(Vec3::new(0.25, 0.25, 0.0), Vec3::new(0.25, 0.25, 1.0));
        assert_eq!(record().blocks(&starts_on), (Stop::Plane, false));
        let ends_on = Ray::segment(Vec3::new(0.25, 0.25, 1.0), Vec3::new(0.25, 0.25, 0.0));
        assert_eq!(record().blocks(&ends_on), (Stop::Plane, false));
        let crosses = Ray::segment(Vec3::new(0.25, 0.25, 1.0), Vec3::new(0.25, 0.25, -1.0));
        assert_eq!(record().blocks(&crosses), (Stop::Hit, true));
    }

    #[test]
    fn a_degenerate_triangle_is_never_hit() {
        let line = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::X * 2.0] };
        let ray = Ray::new(Vec3::new(0.5, 0.0, 1.0), -Vec3::Z, f32::INFINITY);
        assert_eq!(Record::new(&line, PrimitiveId(0)).test(&ray), (Stop::Plane, None));
    }
}
