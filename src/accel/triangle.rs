//! The triangle record and its test, in the phases of an intersection unit: plane, edges, division.

use glam::{Vec2, Vec3};

use super::query::Hit;
use super::ray::{Boxes, Ray};
use crate::quantity::PrimitiveId;
use crate::scene::Triangle;
use crate::stream::Stop;

/// The triangle data that the test reads.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Corner 0.
    pub corner: Vec3,
    /// From corner 0 to corners 1 and 2.
    pub edges: [Vec3; 2],
    /// The cross product of the edges.
    pub normal: Vec3,
    /// The box around the corners.
    bounds: Boxes<1>,
    /// The primitive that the record describes.
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

impl TriangleHit {
    /// The hit on a triangle. `facing`, `distance` and the barycentric coordinates are scaled by the same factor:
    /// division by `facing` gives their values.
    #[inline(always)]
    pub(super) fn new(distance: f32, facing: f32, [u, v]: [f32; 2]) -> Self {
        let scale = 1.0 / facing;
        Self { t: distance / facing, barycentric: Vec2::new(u * scale, v * scale) }
    }

    /// Keeps the hit if it is the nearest so far, and shortens the ray's reach to its distance. At equal distance, the
    /// hit on the lowest primitive is kept.
    #[inline(always)]
    pub(super) fn keep_nearest(self, primitive: PrimitiveId, ray: &mut Ray, nearest: &mut Option<Hit>) {
        let Self { t, barycentric } = self;
        let nearer = nearest.is_none_or(|old| (t, primitive) < (old.t, old.primitive));
        if nearer && t <= ray.reach {
            ray.reach = t;
            *nearest = Some(Hit { primitive, t, barycentric });
        }
    }
}

/// Widens the plane test, so that a hit at exactly the distance of the nearest hit passes it. Its product form rounds
/// differently from the quotient; the tie is settled later, on the quotient.
pub(super) const TIE: f32 = 1.0 + 4.0 * f32::EPSILON;

impl Record {
    /// The record of `triangle`.
    pub fn new(triangle: &Triangle, primitive: PrimitiveId) -> Self {
        let [a, b, c] = triangle.v;
        let edges = [b - a, c - a];
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        Self {
            corner: a,
            edges,
            normal: edges[0].cross(edges[1]),
            bounds: [0, 1, 2].map(|axis| [[low[axis]], [high[axis]]]),
            primitive,
        }
    }

    /// Tests both sides of the triangle, for `0 < t <= ray.reach` (a little beyond, see `TIE`). Moeller-Trumbore with
    /// a stored normal: the plane test is a separate phase, as in the T&I engine's first mode (Nah et al. 2011,
    /// section 4.3).
    pub fn test(&self, ray: &Ray) -> (Stop, Option<TriangleHit>) {
        let towards = -ray.direction.dot(self.normal);
        let sign = 1.0f32.copysign(towards);
        let facing = towards.abs();
        let from_corner = ray.origin - self.corner;
        let distance = from_corner.dot(self.normal) * sign;
        // A degenerate triangle has a zero normal: no distance passes this test.
        if !(distance > 0.0 && distance <= facing * ray.reach * TIE) {
            return (Stop::Plane, None);
        }
        let moment = from_corner.cross(ray.direction);
        let u = self.edges[1].dot(moment) * sign;
        let v = -self.edges[0].dot(moment) * sign;
        if !(u >= 0.0 && v >= 0.0 && u + v <= facing) {
            return (Stop::Edges, None);
        }
        (Stop::Hit, Some(TriangleHit::new(distance, facing, [u, v])))
    }

    /// Whether the triangle blocks the ray: a hit at `0 < t < ray.reach`, by a ray that also meets the triangle's box.
    ///
    /// The edge test and the slab test round differently where an edge lies in a face of the box. Far from the origin,
    /// one in some thousand rays that are aimed at such an edge passes the edge test but not the slab test. Whether a
    /// tree's boxes then hide the triangle depends on where the traversal starts. The triangle's own box lies in all
    /// boxes above it. With the test of this box too, a traversal gives the same answer as testing all triangles one
    /// by one.
    pub fn blocks(&self, ray: &Ray) -> (Stop, bool) {
        match self.test(ray) {
            (_, Some(hit)) => self.confirm(ray, hit.t),
            (stop, None) => (stop, false),
        }
    }

    /// Whether a hit of the edge test, at the distance `t`, blocks the ray.
    #[inline]
    pub(super) fn confirm(&self, ray: &Ray, t: f32) -> (Stop, bool) {
        if t < ray.reach {
            let [entry] = ray.entries(&self.bounds);
            if entry < f32::INFINITY { (Stop::Hit, true) } else { (Stop::Edges, false) }
        } else {
            // Only just out of reach: the hardware's plane test has no tie rule and stops here.
            (Stop::Plane, false)
        }
    }

    /// Tests the triangle and keeps its hit if it is the nearest so far; then the ray's reach is the hit's distance.
    /// At equal distance, the hit on the lowest primitive is kept.
    pub(super) fn test_nearest(&self, ray: &mut Ray, nearest: &mut Option<Hit>) -> Stop {
        let (stop, hit) = self.test(ray);
        if let Some(hit) = hit {
            hit.keep_nearest(self.primitive, ray, nearest);
        }
        stop
    }

    /// Whether the triangle blocks the ray by more than rounding errors. Then the boxes around it cannot miss the ray
    /// either, and a traversal is certain to find a blocker. A hit within the error bound of an edge or an end proves
    /// nothing, because the slab test may round the other way.
    ///
    /// The bounds are those of `shaft`, with 1-norms, which are never shorter than lengths.
    pub fn surely_blocks(&self, ray: &Ray) -> (Stop, bool) {
        const U: f32 = f32::EPSILON;
        let size = |v: Vec3| v.abs().element_sum();
        let (stop, hit) = self.test(ray);
        let Some(hit) = hit else { return (stop, false) };
        let facing = ray.direction.dot(self.normal).abs();
        let far = size(ray.origin - self.corner);
        let [a, b] = self.edges.map(size);
        let (length, area) = (size(ray.direction), a * b);
        let share = 10.0 * U * length * area / facing;
        let along = (10.0 * U * far * area) / facing + 2.0 * share;
        let across = 13.0 * U * far * length * (a + b) / facing + share;
        let Vec2 { x: u, y: v } = hit.barycentric;
        let inside = u >= across && v >= across && u + v <= 1.0 - across;
        // Far below these sizes, products underflow. A comparison with a NaN is false.
        let sizeable = facing > 1e-30 && far * length * a.min(b) > 1e-30;
        (Stop::Hit, sizeable && share < 0.25 && inside && hit.t >= along && hit.t <= ray.reach - along)
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
    fn a_ray_in_the_box_s_face_is_in_the_box() {
        // The ray runs in the plane z = high of the triangle's box, along the edge from corner 0 to corner 1. A slab
        // test that divided by the missing component of the direction would miss the box, and `blocks` with it.
        let corners =
            [[100000.695, 100000.52, 100000.66], [100001.32, 100000.52, 100000.66], [100000.695, 100000.52, 99999.99]];
        let record = Record::new(&Triangle { v: corners.map(Vec3::from_array) }, PrimitiveId(0));
        let direction = Vec3::new(-5.046875, 4.109375, 0.0);
        let ray = Ray::new(Vec3::new(100002.234, 99999.57, 100000.66), direction, 1.0);
        assert_eq!(record.test(&ray).0, Stop::Hit);
        assert_eq!(record.blocks(&ray), (Stop::Hit, true));
    }

    #[test]
    fn a_degenerate_triangle_is_never_hit() {
        let line = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::X * 2.0] };
        let ray = Ray::new(Vec3::new(0.5, 0.0, 1.0), -Vec3::Z, f32::INFINITY);
        assert_eq!(Record::new(&line, PrimitiveId(0)).test(&ray), (Stop::Plane, None));
    }
}
