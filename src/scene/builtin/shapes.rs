//! Shapes that scenes are made of: tiled planes and boxes, bodies of revolution. The outside is counter-clockwise.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec2, DVec3};

use crate::random;
use crate::scene::geometry::{Attributes, Geometry, Triangle};
use crate::scene::material::MaterialId;

/// Adds shapes to a geometry, each at the place and of the material set before.
#[derive(Debug, Default)]
pub(crate) struct Shapes {
    /// The shapes so far.
    pub geometry: Geometry,
    /// From the shape's space to that of the geometry.
    pub at: DAffine3,
    /// The material.
    pub material: MaterialId,
}

/// A corner: place, normal if the surface is round there, and texture coordinates.
type Corner = (DVec3, Option<DVec3>, DVec2);

impl Shapes {
    /// Sets the place: a shift, after a turn about the vertical by `degrees`.
    pub(crate) fn place(&mut self, shift: DVec3, degrees: f64) -> &mut Self {
        self.at = DAffine3::from_rotation_translation(DQuat::from_rotation_y(degrees.to_radians()), shift);
        self
    }

    /// Sets the material.
    pub(crate) fn paint(&mut self, material: MaterialId) -> &mut Self {
        self.material = material;
        self
    }

    /// A flat triangle.
    pub(crate) fn triangle(&mut self, corners: [DVec3; 3]) {
        self.push(corners.map(|corner| (corner, None, DVec2::ZERO)));
    }

    fn push(&mut self, corners: [Corner; 3]) {
        let upright = self.at.matrix3.inverse().transpose();
        let normals = match corners.map(|corner| corner.1) {
            [Some(a), Some(b), Some(c)] => Some([a, b, c].map(|n| (upright * n).normalize_or_zero().as_vec3())),
            _ => None,
        };
        let triangle = Triangle { v: corners.map(|corner| self.at.transform_point3(corner.0).as_vec3()) };
        self.geometry.push(
            triangle,
            Attributes { normals, uv: corners.map(|corner| corner.2.as_vec2()), material: self.material },
        );
    }

    fn quad(&mut self, [a, b, c, d]: [Corner; 4]) {
        self.push([a, b, c]);
        self.push([a, c, d]);
    }

    /// A parallelogram at `corner` with the edges `u` and `v`, in tiles of two triangles with edges of at most `tile`.
    /// Its front is the side of `u` x `v`. A texture repeats after every world unit.
    pub(crate) fn plane(&mut self, corner: DVec3, u: DVec3, v: DVec3, tile: f64) {
        let count = |edge: DVec3| (edge.length() / tile - 1e-9).ceil().max(1.0) as u32;
        let (across, along) = (count(u), count(v));
        let (width, height) = (u.length(), v.length());
        let at = |i: u32, j: u32| {
            let (s, t) = (f64::from(i) / f64::from(across), f64::from(j) / f64::from(along));
            (corner + u * s + v * t, None, DVec2::new(s * width, t * height))
        };
        for j in 0..along {
            for i in 0..across {
                self.quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }

    /// The box from `low` to `high`, seen from outside, in tiles of at most `tile`.
    pub(crate) fn cuboid(&mut self, low: DVec3, high: DVec3, tile: f64) {
        let size = high - low;
        let (x, y, z) = (DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z);
        for (corner, u, v) in [(low, y, x), (low, z, y), (low, x, z), (high, -x, -y), (high, -y, -z), (high, -z, -x)] {
            self.plane(corner, u, v, tile);
        }
    }

    /// The body of revolution about the vertical through `outline` (radius and height), which runs upwards on the
    /// outside. It is smooth along and around, with an edge where a point occurs twice; points of radius 0 close it.
    pub(crate) fn lathe(&mut self, outline: &[DVec2], segments: usize) {
        let ring = |k: usize| DVec2::from_angle(-TAU * (k % segments) as f64 / segments as f64);
        let last = outline.len() - 1;
        let facing = |i: usize| (outline[i + 1] - outline[i]).perp().normalize_or_zero() * -1.0;
        for i in 0..last {
            let (from, to) = (outline[i], outline[i + 1]);
            if from == to {
                continue;
            }
            let here = facing(i);
            let below = if i > 0 { (here + facing(i - 1)).normalize_or(here) } else { here };
            let above = if i + 1 < last { (here + facing(i + 1)).normalize_or(here) } else { here };
            // Beside a doubled point the neighbour's normal is zero, so the sum is this face's own normal.
            let corner = |k: usize, point: DVec2, normal: DVec2| {
                let around = ring(k);
                let turn = |p: DVec2| DVec3::new(p.x * around.x, p.y, p.x * around.y);
                (turn(point), Some(turn(normal)), DVec2::new(k as f64 / segments as f64, point.y))
            };
            for k in 0..segments {
                let [a, b] = [corner(k, from, below), corner(k + 1, from, below)];
                let [c, d] = [corner(k + 1, to, above), corner(k, to, above)];
                match (from.x == 0.0, to.x == 0.0) {
                    (true, _) => self.push([a, c, d]),
                    (_, true) => self.push([a, b, d]),
                    _ => self.quad([a, b, c, d]),
                }
            }
        }
    }

    /// A sphere with `segments` around its equator and half as many from pole to pole.
    pub(crate) fn sphere(&mut self, centre: DVec3, radius: f64, segments: usize) {
        let rings = (segments / 2).max(2);
        let outline: Vec<DVec2> = (0..=rings)
            .map(|i| {
                let (y, x) = (0.5 * TAU * (i as f64 / rings as f64 - 0.5)).sin_cos();
                // The poles lie on the axis exactly.
                DVec2::new(if i == 0 || i == rings { 0.0 } else { radius * x }, radius * y)
            })
            .collect();
        self.shifted(centre, |shapes| shapes.lathe(&outline, segments));
    }

    /// A closed upright cylinder that stands on `base`, narrowing from radius `bottom` to radius `top`.
    pub(crate) fn column(&mut self, base: DVec3, [bottom, top]: [f64; 2], height: f64, segments: usize) {
        let outline = [(0.0, 0.0), (bottom, 0.0), (bottom, 0.0), (top, height), (top, height), (0.0, height)];
        self.shifted(base, |shapes| shapes.lathe(&outline.map(DVec2::from), segments));
    }

    /// A ring of radius `major` in the horizontal plane around `centre`, as thick as `minor`.
    pub(crate) fn torus(&mut self, centre: DVec3, major: f64, minor: f64, segments: [usize; 2]) {
        let outline: Vec<DVec2> = (0..=segments[1])
            .map(|i| {
                DVec2::new(major, 0.0) + DVec2::from_angle(TAU * (i % segments[1]) as f64 / segments[1] as f64) * minor
            })
            .collect();
        self.shifted(centre, |shapes| shapes.lathe(&outline, segments[0]));
    }

    /// Calls `make` with the origin moved to `origin`.
    pub(crate) fn shifted(&mut self, origin: DVec3, make: impl FnOnce(&mut Self)) {
        let before = self.at;
        self.at = before * DAffine3::from_translation(origin);
        make(self);
        self.at = before;
    }
}

/// A number from 0 to 1 that is always the same for the same seed.
pub(crate) fn hash(seed: u64) -> f64 {
    random::unit(random::mix(seed.wrapping_mul(random::GOLDEN)))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// The volume inside: positive if closed and counter-clockwise from outside.
    fn volume(geometry: &Geometry) -> f64 {
        let of = |t: &Triangle| t.v[0].as_dvec3().dot(t.v[1].as_dvec3().cross(t.v[2].as_dvec3()));
        geometry.triangles.iter().map(of).sum::<f64>() / 6.0
    }

    fn made(make: impl FnOnce(&mut Shapes)) -> Geometry {
        let mut shapes = Shapes::default();
        make(&mut shapes);
        shapes.geometry
    }

    #[test]
    fn volumes_are_those_of_solids_seen_from_outside() {
        let cuboid = made(|s| s.cuboid(DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 4.0, 6.0), 0.4));
        assert!((volume(&cuboid) - 6.0).abs() < 1e-5);
        // Edges of 1, 2 and 3 in tiles of at most 0.4 make 3, 5 and 8 tiles.
        assert_eq!(cuboid.len(), 2 * 2 * (3 * 5 + 5 * 8 + 3 * 8));
        let sphere = made(|s| s.sphere(DVec3::ONE, 2.0, 64));
        assert!((volume(&sphere) / (TAU * 2.0 / 3.0 * 8.0) - 1.0).abs() < 0.01);
        assert_eq!(sphere.len(), 64 * (2 * 30 + 2));
        let column = made(|s| s.column(DVec3::X, [1.0, 1.0], 3.0, 64));
        assert!((volume(&column) / (TAU * 0.5 * 3.0) - 1.0).abs() < 0.01);
        let torus = made(|s| s.torus(DVec3::ZERO, 2.0, 0.5, [64, 32]));
        assert!((volume(&torus) / (TAU * 2.0 * TAU * 0.5 * 0.25) - 1.0).abs() < 0.02);
    }

    #[test]
    fn normals_of_round_shapes_are_unit_and_on_the_front() {
        let round = made(|s| {
            s.place(DVec3::new(3.0, 0.0, 1.0), 30.0).sphere(DVec3::Y, 1.0, 24);
            s.column(DVec3::ZERO, [0.5, 0.2], 1.0, 24);
            s.torus(DVec3::ZERO, 2.0, 0.5, [24, 12]);
        });
        for (triangle, attributes) in round.triangles.iter().zip(&round.attributes) {
            for normal in attributes.normals.unwrap() {
                assert!((normal.length() - 1.0).abs() < 1e-5);
                assert!(normal.dot(triangle.normal().normalize()) > 0.7, "{triangle:?} {normal}");
            }
        }
    }

    #[test]
    fn the_hash_is_fixed_and_even() {
        // SplitMix64 of state 0 starts with 0xe220a8397b1dcdaf.
        assert_eq!(hash(0), (0xe220_a839_7b1d_cdaf_u64 >> 11) as f64 / (1u64 << 53) as f64);
        let mean = (0..10_000).map(hash).sum::<f64>() / 1e4;
        assert!((mean - 0.5).abs() < 0.01);
        assert!((0..10_000).all(|seed| (0.0..1.0).contains(&hash(seed))));
    }

    #[test]
    fn a_plane_faces_the_side_of_its_edges_product() {
        let plane = made(|s| s.plane(DVec3::ZERO, DVec3::X * 2.0, DVec3::Y, 0.5));
        assert_eq!(plane.len(), 16);
        assert!(plane.triangles.iter().all(|triangle| triangle.normal().normalize() == Vec3::Z));
    }
}
