//! Rays, and their tests against triangles and boxes.

use glam::{DVec3, Vec3};

use crate::scene::Triangle;

/// Boxes are widened by this share of the largest coordinate in use. It is thousands of times the rounding error of a
/// box test (three roundings of 2^-53 each), and far below the spacing of `f32` corners.
const PAD: f64 = 1e-12;

/// Smaller direction components count as zero; the inverse stays finite, so that no box test gives a NaN.
const TINY: f64 = 1e-300;

/// A ray, with precomputed values for its tests.
///
/// The triangle test is that of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2(1), 2013). The
/// axis with the ray's largest direction component becomes z, a shear turns the ray to this axis, and the signs of
/// three 2D edge functions decide. Two triangles that share an edge get the same value of its function, so no ray
/// slips through.
pub(super) struct Ray {
    origin: DVec3,
    /// x, y and z of the sheared space, as indices of world axes.
    axes: [usize; 3],
    /// Shift of x and y per step along z, and the length of the step in t.
    shear: [f64; 3],
    /// The origin, moved towards larger and towards smaller coordinates: for the low and the high sides of boxes.
    from_low: DVec3,
    from_high: DVec3,
    inverse: DVec3,
}

/// Where a ray meets a triangle's plane inside the triangle.
pub(super) struct Crossing {
    /// Position on the ray, in lengths of its direction.
    pub t: f64,
    /// The weights of the three corners; they add up to 1.
    pub weights: [f64; 3],
}

impl Ray {
    /// A ray through geometry whose coordinates have a magnitude of at most `reach`.
    pub(super) fn new(origin: DVec3, direction: DVec3, reach: f64) -> Self {
        let d = direction.to_array();
        let z = (0..3).fold(0, |longest, axis| if d[axis].abs() > d[longest].abs() { axis } else { longest });
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let pad = DVec3::splat(PAD * (reach + origin.abs().max_element()));
        let inverse = |along: f64| 1.0 / if along.abs() < TINY { TINY.copysign(along) } else { along };
        Self {
            origin,
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z], 1.0 / d[z]],
            from_low: origin + pad,
            from_high: origin - pad,
            inverse: DVec3::new(inverse(d[0]), inverse(d[1]), inverse(d[2])),
        }
    }

    /// The point where the line of the ray meets a triangle, edges included, from either side. A line in the
    /// triangle's plane does not meet it.
    pub(super) fn meet(&self, triangle: &Triangle) -> Option<Crossing> {
        let [x, y, z] = self.axes;
        let [a, b, c] = triangle.v.map(|corner| {
            let corner = (corner.as_dvec3() - self.origin).to_array();
            [corner[x] - self.shear[0] * corner[z], corner[y] - self.shear[1] * corner[z], corner[z]]
        });
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let t = self.shear[2] * (u * a[2] + v * b[2] + w * c[2]) / sum;
        Some(Crossing { t, weights: [u / sum, v / sum, w / sum] })
    }

    /// The t at which the ray enters a box, if it is from 0 to `limit`; rounding errors count as entering.
    pub(super) fn enter(&self, low: Vec3, high: Vec3, limit: f64) -> Option<f64> {
        let first = (low.as_dvec3() - self.from_low) * self.inverse;
        let second = (high.as_dvec3() - self.from_high) * self.inverse;
        let near = first.min(second).max_element().max(0.0);
        let far = first.max(second).min_element().min(limit);
        (near <= far).then_some(near)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The test of Moeller and Trumbore (1997): t and the weights of the second and third corner.
    fn textbook(origin: DVec3, direction: DVec3, triangle: &Triangle) -> (f64, f64, f64) {
        let [a, b, c] = triangle.v.map(|corner| corner.as_dvec3());
        let (ab, ac, from) = (b - a, c - a, origin - a);
        let p = direction.cross(ac);
        let q = from.cross(ab);
        let det = ab.dot(p);
        (ac.dot(q) / det, from.dot(p) / det, direction.dot(q) / det)
    }

    fn vector() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-10.0f32..10.0).prop_map(Vec3::from)
    }

    proptest! {
        #[test]
        fn agrees_with_moeller_and_trumbore(v in prop::array::uniform3(vector()), o in vector(), d in vector()) {
            let triangle = Triangle { v };
            let (origin, direction) = (o.as_dvec3(), d.as_dvec3());
            let slant = direction.dot(triangle.normal().as_dvec3()).abs();
            prop_assume!(slant > 1e-3);
            let (t, second, third) = textbook(origin, direction, &triangle);
            let first = 1.0 - second - third;
            let margin = first.min(second).min(third);
            prop_assume!(margin.abs() > 1e-9);
            match Ray::new(origin, direction, 10.0).meet(&triangle) {
                Some(at) => {
                    prop_assert!(margin > 0.0);
                    prop_assert!((at.t - t).abs() <= 1e-9 * t.abs().max(1.0), "{} {t}", at.t);
                    for (ours, theirs) in at.weights.into_iter().zip([first, second, third]) {
                        prop_assert!((ours - theirs).abs() < 1e-9);
                    }
                }
                None => prop_assert!(margin < 0.0),
            }
        }

        /// A ray through the cut of a parallelogram does not slip between its two triangles.
        #[test]
        fn shared_edges_are_tight(v in prop::array::uniform3(vector()), share in 0.0f64..1.0, o in vector()) {
            let [a, b, left] = v;
            let right = a + b - left;
            let origin = o.as_dvec3() * 3.0;
            let ray = Ray::new(origin, a.as_dvec3().lerp(b.as_dvec3(), share) - origin, 30.0);
            let halves = [Triangle { v: [a, b, left] }, Triangle { v: [b, a, right] }];
            prop_assume!((origin - a.as_dvec3()).dot(halves[0].normal().as_dvec3()).abs() > 1e-3);
            prop_assert!(halves.iter().any(|half| ray.meet(half).is_some()));
        }
    }

    #[test]
    fn a_ray_on_a_box_side_enters_it() {
        let (low, high) = (Vec3::ZERO, Vec3::ONE);
        for x in [0.0, 1.0] {
            let ray = Ray::new(DVec3::new(x, 0.5, 5.0), DVec3::NEG_Z, 1.0);
            let near = ray.enter(low, high, f64::INFINITY).expect("on the side");
            assert!((near - 4.0).abs() < 1e-9);
            assert!(ray.enter(low, high, 3.9).is_none());
        }
        assert!(Ray::new(DVec3::new(1.1, 0.5, 5.0), DVec3::NEG_Z, 1.0).enter(low, high, f64::INFINITY).is_none());
    }

    #[test]
    fn lines_in_the_plane_and_no_lines_meet_nothing() {
        let triangle = Triangle { v: [Vec3::ZERO, Vec3::X, Vec3::Y] };
        assert!(Ray::new(DVec3::new(-1.0, 0.2, 0.0), DVec3::X, 1.0).meet(&triangle).is_none());
        let nowhere = Ray::new(DVec3::new(0.2, 0.2, 1.0), DVec3::ZERO, 1.0).meet(&triangle);
        assert!(nowhere.is_none_or(|at| at.t.is_nan()));
    }
}
