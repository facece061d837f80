//! Replaces spheres, cones and cylinders by triangles, since the accelerator has triangles only.
//!
//! Corners lie on the true surface and carry its normals. So the triangles of a convex shape lie inside it by at most
//! `1 - cos(pi / SEGMENTS)` = 0.5 % of the radius.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Corners around a circle.
pub(crate) const SEGMENTS: usize = 32;
/// Bands of a sphere from pole to pole.
pub(crate) const BANDS: usize = 16;

/// A triangle with the true surface's unit normals at its corners. The corners run counter-clockwise as seen from
/// where the normals point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SmoothTriangle {
    /// The corners.
    pub v: [DVec3; 3],
    /// The normals.
    pub normals: [DVec3; 3],
}

impl SmoothTriangle {
    /// The same triangle, seen from the other side.
    fn reversed(self) -> Self {
        let [a, b, c] = self.v;
        let [na, nb, nc] = self.normals;
        Self { v: [a, c, b], normals: [-na, -nc, -nb] }
    }
}

/// A sphere in `2 * SEGMENTS * (BANDS - 1)` triangles; a negative `radius` shows the inside.
pub(crate) fn sphere(center: DVec3, radius: f64) -> Vec<SmoothTriangle> {
    let direction = |band: usize, segment: usize| match band {
        0 => DVec3::Y,
        BANDS => DVec3::NEG_Y,
        _ => {
            let (sin, cos) = (PI * band as f64 / BANDS as f64).sin_cos();
            circle((segment % SEGMENTS) as f64, DVec3::Z, DVec3::X) * sin + DVec3::Y * cos
        }
    };
    let triangle = |normals: [DVec3; 3]| SmoothTriangle { v: normals.map(|n| center + n * radius.abs()), normals };
    let mut triangles = Vec::with_capacity(2 * SEGMENTS * (BANDS - 1));
    for band in 0..BANDS {
        for segment in 0..SEGMENTS {
            let [a, b] = [direction(band, segment), direction(band, segment + 1)];
            let [c, d] = [direction(band + 1, segment), direction(band + 1, segment + 1)];
            if band + 1 < BANDS {
                triangles.push(triangle([a, c, d]));
            }
            if band > 0 {
                triangles.push(triangle([a, d, b]));
            }
        }
    }
    facing(triangles, radius < 0.0)
}

/// A cone or cylinder without caps in `2 * SEGMENTS` triangles, half of that if one radius is 0. Negative radii show
/// the inside. `base` and `apex` must differ, and the radii must not differ in sign.
pub(crate) fn cone(base: DVec3, base_radius: f64, apex: DVec3, apex_radius: f64) -> Vec<SmoothTriangle> {
    let height = base.distance(apex);
    let axis = (apex - base) / height;
    let (x, y) = axis.any_orthonormal_pair();
    // How much the surface widens towards the base.
    let slope = base_radius.abs() - apex_radius.abs();
    let normal = |segment: f64| (circle(segment, x, y) * height + axis * slope).normalize();
    let point =
        |center: DVec3, radius: f64, segment: usize| center + circle((segment % SEGMENTS) as f64, x, y) * radius.abs();
    let mut triangles = Vec::with_capacity(2 * SEGMENTS);
    for segment in 0..SEGMENTS {
        // The tip of a true cone has no unique normal: the normal in the middle of the segment is used.
        let [left, middle, right] = [0.0, 0.5, 1.0].map(|part| normal(segment as f64 + part));
        let [a, b] = [point(base, base_radius, segment), point(base, base_radius, segment + 1)];
        let [c, d] = [point(apex, apex_radius, segment), point(apex, apex_radius, segment + 1)];
        if base_radius != 0.0 {
            let top = if apex_radius == 0.0 { middle } else { right };
            triangles.push(SmoothTriangle { v: [a, b, d], normals: [left, right, top] });
        }
        if apex_radius != 0.0 {
            let bottom = if base_radius == 0.0 { middle } else { left };
            triangles.push(SmoothTriangle { v: [a, d, c], normals: [bottom, right, left] });
        }
    }
    facing(triangles, base_radius < 0.0 || apex_radius < 0.0)
}

/// The unit vector `segment` segments from `x` towards `y`.
fn circle(segment: f64, x: DVec3, y: DVec3) -> DVec3 {
    let (sin, cos) = (TAU * segment / SEGMENTS as f64).sin_cos();
    x * cos + y * sin
}

fn facing(triangles: Vec<SmoothTriangle>, inwards: bool) -> Vec<SmoothTriangle> {
    if inwards { triangles.into_iter().map(SmoothTriangle::reversed).collect() } else { triangles }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// The volume that closed triangles enclose; negative if they face inwards.
    fn volume(triangles: &[SmoothTriangle]) -> f64 {
        triangles.iter().map(|t| t.v[0].dot(t.v[1].cross(t.v[2])) / 6.0).sum()
    }

    fn area(triangles: &[SmoothTriangle]) -> f64 {
        triangles.iter().map(|t| 0.5 * (t.v[1] - t.v[0]).cross(t.v[2] - t.v[0]).length()).sum()
    }

    /// Number of edges without an opposite edge through bit-equal corners.
    fn open_edges(triangles: &[SmoothTriangle]) -> usize {
        let key = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
        let mut edges = BTreeMap::new();
        for t in triangles {
            for i in 0..3 {
                *edges.entry((key(t.v[i]), key(t.v[(i + 1) % 3]))).or_insert(0) += 1;
            }
        }
        assert!(edges.values().all(|&count| count == 1));
        edges.keys().filter(|(from, to)| !edges.contains_key(&(*to, *from))).count()
    }

    fn front_is_where_normals_point(triangles: &[SmoothTriangle]) {
        for t in triangles {
            let front = (t.v[1] - t.v[0]).cross(t.v[2] - t.v[0]).normalize();
            assert!(t.normals.iter().all(|n| front.dot(*n) > 0.97 && (n.length() - 1.0).abs() < 1e-12));
        }
    }

    #[test]
    fn spheres_are_closed_and_lie_on_the_sphere() {
        let center = DVec3::new(1.0, 2.0, 3.0);
        for (radius, sign) in [(2.0, 1.0), (-2.0, -1.0)] {
            let triangles = sphere(center, radius);
            assert_eq!(triangles.len(), 960);
            assert_eq!(open_edges(&triangles), 0);
            front_is_where_normals_point(&triangles);
            let relative = volume(&triangles) * sign / (4.0 / 3.0 * PI * 8.0);
            assert!((0.97..1.0).contains(&relative), "{relative}");
            for t in &triangles {
                for i in 0..3 {
                    assert!(t.v[i].distance(center + t.normals[i] * radius) < 1e-12);
                }
            }
        }
    }

    #[test]
    fn cones_have_two_open_ends() {
        let (base, apex) = (DVec3::new(1.0, 0.0, -2.0), DVec3::new(3.0, 1.0, 0.0));
        let slant = |r0: f64, r1: f64| PI * (r0 + r1) * (9.0 + (r0 - r1) * (r0 - r1)).sqrt();
        for (r0, r1, count, open) in [(1.0, 1.0, 64, 64), (2.0, 0.5, 64, 64), (1.5, 0.0, 32, 32), (0.0, 1.5, 32, 32)] {
            for sign in [1.0, -1.0] {
                let triangles = cone(base, sign * r0, apex, sign * r1);
                assert_eq!(triangles.len(), count);
                assert_eq!(open_edges(&triangles), open);
                front_is_where_normals_point(&triangles);
                let relative = area(&triangles) / slant(r0, r1);
                assert!((0.99..1.0).contains(&relative), "{relative}");
                let outwards = triangles.iter().all(|t| {
                    let middle = (t.v[0] + t.v[1] + t.v[2]) / 3.0;
                    let along = (middle - base).dot(apex - base) / 9.0;
                    t.normals[0].dot(middle - base.lerp(apex, along)) > 0.0
                });
                assert_eq!(outwards, sign > 0.0);
            }
        }
    }
}
