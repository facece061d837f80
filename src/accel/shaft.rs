//! Shafts: all shadow rays from a piece of a surface to a lamp, and what the static tree proves about them.
//!
//! A certificate must predict the tracer's `f32` answer for every ray of the shaft, not the answer in real numbers. So
//! this module does not ask whether the shaft meets a triangle. It asks whether [`Record::blocks`] and the tree's slab
//! test *can* or *must* answer "blocked"; an error bound separates the two.
//!
//! **Notation.** `u` = 2^-24, half a unit in the last place of 1. A ray starts at `o`, ends at the light `L`, and has
//! `d = fl(L - o)`. A record has a corner `A` and edges `a`, `b`, all of them `f32` and taken as exact. With `s = o -
//! A`, `n = a x b` and `m = L - A`, the quantities that the triangle test compares are
//!
//! - `D = n.s` (height over the plane) and `F = -n.d = n.(o - L)` (how much the ray faces it),
//! - `U = b.(s x d) = b.(s x m)` and `V = -a.(s x d) = -a.(s x m)`, because `d = m - s` and `s x s = 0`.
//!
//! All four are affine in `o`. An inequality between them that holds at the three corners of a piece of a surface
//! holds in all of it: three evaluations in `f64` decide for every ray to `L`. A lamp is one point, or several points
//! of a rectangle. With several points, each point is decided separately; the shaft reports what holds for all.
//!
//! **Error bound.** The standard model is `fl(x op y) = (x op y)(1 + e)`, `|e| <= u`, to first order in `u`. A
//! difference of vectors errs by `u |.|`, a cross product by `4 u |.||.|`, a dot product by `3 u |.||.|`. Hence
//! `|fl(D) - D| <= 8 u |s||a||b|`, `|fl(F) - F| <= 8 u |d||a||b|`, `|fl(U) - U| <= 9 u |s||d||b|`, `|fl(V) - V| <= 9 u
//! |s||d||a|`. The code takes 10, 10, 12 and 12, and adds for the sum `U + V` and for the tie rule of the plane test.
//! Products that underflow err by less than [`UNDERFLOW`] each; where a product could overflow, nothing is certified.
//! Starting points may lie up to `spread` off the lifted piece (see [`Shaft::new`]): each bound grows by the gradient
//! times `spread`.
//!
//! **Boxes.** A node is left out only if the slab test must miss its box. Entry and exit distances err by 4 u of
//! themselves and are compared with a factor of 1 + 16 u. So the slab test misses every box that is more than `26 u
//! |d|` away from the ray; the same holds for the comparisons with a kd-tree's planes. The margin is `48 u |d|`, plus
//! the spread, plus the shift by [`Ray`](super::Ray)'s smallest component. In the other direction, the slab test never
//! misses a box that the ray meets. If a triangle must be hit inside its edges by the bound above, the hit point is in
//! the box of its corners, and so in the boxes of all ancestors.
//!
//! **Counts.** A visited node counts as one visit, as for a ray. A triangle that is tested against a shaft counts as
//! one test: one record is read, and evaluated for three corners (and all points of the lamp) at once.

use glam::{DVec3, Vec3};
use smallvec::SmallVec;

use super::trail::Observer;
use super::triangle::Record;
use crate::quantity::TriangleSlot;
use crate::stream::Stop;

/// Half a unit in the last place of 1 in `f32`.
const U: f64 = 1.0 / (1u64 << 24) as f64;
/// More than the error of one underflowing product or sum of the triangle test, times the number of operations.
const UNDERFLOW: f64 = 1e-43;
/// Far enough below the largest `f32` that no intermediate result of the test overflows.
const OVERFLOW: f64 = 1e37;

/// All shadow rays from a triangular piece of a surface to the points of a lamp.
#[derive(Clone, Debug)]
pub struct Shaft {
    corners: [DVec3; 3],
    beams: SmallVec<[Beam; 1]>,
    spread: f64,
    /// Length of the longest ray.
    length: f64,
    /// Minimum distance of a box that the shaft certainly misses.
    margin: f64,
    low: DVec3,
    high: DVec3,
    /// Axes that can separate the shaft from a box, besides the box's own axes, with the shaft's extent on each.
    axes: SmallVec<[Axis; AXES]>,
}

/// The rays to one point of the lamp.
#[derive(Clone, Copy, Debug)]
struct Beam {
    light: DVec3,
    /// The faces of the tetrahedron that the rays fill.
    faces: [Axis; 4],
}

/// Number of axes of a beam: four faces, and the cross products of six edges with three box axes.
const AXES: usize = 4 + 6 * 3;

#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    direction: DVec3,
    low: f64,
    high: f64,
}

impl Axis {
    fn new(direction: DVec3, points: &[DVec3]) -> Self {
        let on = points.iter().map(|point| point.dot(direction));
        let (low, high) = on.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), on| (low.min(on), high.max(on)));
        Self { direction, low, high }
    }
}

/// The relation of a triangle to a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The triangle blocks no ray of the shaft.
    Misses,
    /// The triangle blocks every ray of the shaft.
    Covers,
    /// Neither is certain.
    Crosses,
}

/// Knowledge of the static blockers of all rays of a shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// No ray has a static blocker.
    Clear,
    /// One triangle blocks every ray.
    Blocked,
    /// Unknown: a triangle prevents a proof that there is no blocker.
    Unknown,
}

impl Relation {
    /// The shaft's answer if this triangle decides it; `None` if the triangle misses the shaft.
    pub(super) fn sight(self) -> Option<Sight> {
        match self {
            Self::Misses => None,
            Self::Covers => Some(Sight::Blocked),
            Self::Crosses => Some(Sight::Unknown),
        }
    }
}

impl Shaft {
    /// The rays to `lights`, the points of a lamp, that start at most `spread` away from the triangle `corners`.
    pub fn new(corners: [DVec3; 3], lights: &[Vec3], spread: f64) -> Self {
        let [a, b, c] = corners;
        let lights: SmallVec<[DVec3; 1]> = lights.iter().map(|light| light.as_dvec3()).collect();
        let rays = corners.iter().flat_map(|corner| lights.iter().map(move |light| corner.distance(*light)));
        let length = rays.fold(0.0, f64::max) + spread;
        // 1e-18 is a hundred times the shift of a ray whose smallest direction component is set to 1e-20.
        let margin = 48.0 * U * length + spread + 1e-18;
        let points: SmallVec<[DVec3; 4]> = corners.into_iter().chain(lights.iter().copied()).collect();
        let sides = [b - a, c - b, a - c];
        let faces = |light: DVec3, points: &[DVec3]| {
            let beams = [light - a, light - b, light - c];
            let [ab, bc, ca] = [0, 1, 2].map(|at| Axis::new(sides[at].cross(beams[at]), points));
            [Axis::new(sides[0].cross(sides[1]), points), ab, bc, ca]
        };
        let beams = lights.iter().map(|&light| Beam { light, faces: faces(light, &[a, b, c, light]) }).collect();
        // Any axis is valid, because its extent covers all points. The axes of the beams to a rectangle's corners are
        // enough.
        let mut axes = SmallVec::new();
        for &light in corner_points(&lights) {
            axes.extend(faces(light, &points));
            for direction in sides.into_iter().chain([light - a, light - b, light - c]) {
                let across = [DVec3::X, DVec3::Y, DVec3::Z].map(|unit| Axis::new(direction.cross(unit), &points));
                axes.extend(across);
            }
        }
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min) - margin;
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max) + margin;
        Self { corners, beams, spread, length, margin, low, high, axes }
    }

    /// Whether no ray can pass the slab test of the box.
    pub(super) fn misses_box(&self, low: DVec3, high: DVec3) -> bool {
        if self.low.cmpgt(high).any() || self.high.cmplt(low).any() {
            return true;
        }
        let (center, half) = ((low + high) * 0.5, (high - low) * 0.5);
        self.axes.iter().any(|axis| {
            let middle = center.dot(axis.direction);
            let reach = half.dot(axis.direction.abs()) + self.margin * axis.direction.length();
            middle - reach > axis.high || middle + reach < axis.low
        })
    }

    /// Tests the triangle in `slot` against the rays, and records the test.
    pub(super) fn test(&self, slot: TriangleSlot, record: &Record, watch: &mut impl Observer) -> Relation {
        let (stop, relation) = self.relation(record);
        watch.triangle(slot, stop);
        relation
    }

    /// The triangle's relation to the rays, and the phase of the triangle test that decided it.
    pub fn relation(&self, record: &Record) -> (Stop, Relation) {
        let mut beams = self.beams.iter().map(|beam| self.relation_to(beam, record));
        let first = beams.next().unwrap_or((Stop::Plane, Relation::Misses));
        beams
            .try_fold(first, |(stop, all), (further, next)| {
                let stop = if further as u32 > stop as u32 { further } else { stop };
                if next == all && all != Relation::Crosses {
                    Ok((stop, all))
                } else {
                    Err((Stop::Hit, Relation::Crosses))
                }
            })
            .unwrap_or_else(|crosses| crosses)
    }

    /// The triangle's relation to the rays of one beam.
    fn relation_to(&self, beam: &Beam, record: &Record) -> (Stop, Relation) {
        let corner = record.corner.as_dvec3();
        let [a, b] = record.edges.map(|edge| edge.as_dvec3());
        let normal = a.cross(b);
        let to_light = beam.light - corner;
        let from_corner = self.corners.map(|at| at - corner);
        let (length_a, length_b) = (a.length(), b.length());
        let far = from_corner.iter().map(|s| s.length()).fold(0.0, f64::max) + self.spread;
        let area = length_a * length_b;
        let moment = far * self.length;
        if !(moment.max(1.0) * (length_a + length_b).max(1.0) < OVERFLOW && self.length.max(far) * area < OVERFLOW) {
            return (Stop::Edges, Relation::Crosses);
        }
        let tiny = UNDERFLOW * (1.0 + far + self.length) * (1.0 + length_a + length_b);
        let stray = self.spread * normal.length() + tiny;
        // Bounds on the errors of D, F, F - D with the tie rule, U, V, and F - U - V.
        let of_height = 10.0 * U * far * area + stray;
        let of_facing = 10.0 * U * self.length * area + stray;
        let of_rest = of_height + 2.0 * of_facing;
        let stray_u = self.spread * length_b * to_light.length() + tiny;
        let stray_v = self.spread * length_a * to_light.length() + tiny;
        let of_u = 12.0 * U * moment * length_b + stray_u;
        let of_v = 12.0 * U * moment * length_a + stray_v;
        let of_w = 13.0 * U * moment * (length_a + length_b) + stray_u + stray_v + of_facing;

        let height = from_corner.map(|s| s.dot(normal));
        // D - F is the light's own height, which is the same for all rays.
        let light_height = to_light.dot(normal);
        let facing = height.map(|height| height - light_height);
        let all = |values: [f64; 3], limit: f64| values.into_iter().all(|value| value >= limit);
        let negated = |values: [f64; 3]| values.map(|value: f64| -value);
        let (front, back) = (all(facing, of_facing), all(negated(facing), of_facing));
        // The test multiplies all terms by the sign of F. The plane test excludes a sign if F never has this sign, if
        // the height does not have it, or if the light is on the same side.
        let plane_front = back || all(negated(height), of_height) || light_height >= of_rest;
        let plane_back = front || all(height, of_height) || -light_height >= of_rest;
        if plane_front && plane_back {
            return (Stop::Plane, Relation::Misses);
        }
        let moments = from_corner.map(|s| s.cross(to_light));
        let u = moments.map(|moment| b.dot(moment));
        let v = moments.map(|moment| -a.dot(moment));
        let w = [0, 1, 2].map(|at| facing[at] - u[at] - v[at]);
        let outside_front = all(negated(u), of_u) || all(negated(v), of_v) || all(negated(w), of_w);
        let outside_back = all(u, of_u) || all(v, of_v) || all(w, of_w);
        if (plane_front || outside_front) && (plane_back || outside_back) {
            return (Stop::Edges, Relation::Misses);
        }
        let covers_front =
            front && all(height, of_height) && -light_height >= of_rest && all(u, of_u) && all(v, of_v) && all(w, of_w);
        let covers_back = back
            && all(negated(height), of_height)
            && light_height >= of_rest
            && all(negated(u), of_u)
            && all(negated(v), of_v)
            && all(negated(w), of_w);
        if covers_front || covers_back {
            return (Stop::Hit, Relation::Covers);
        }
        // Separate by the faces of the shaft, if the rays face the triangle enough to bound the place of a hit.
        if front || back {
            let least = facing.into_iter().fold(f64::INFINITY, |least, facing| least.min(facing.abs())) - of_facing;
            let on_plane = 2.0 * ((of_u + of_w) * length_a + (of_v + of_w) * length_b);
            let margin = (on_plane + of_rest.max(of_height) * self.length) / least + self.margin;
            let apart = beam.faces.iter().any(|axis| {
                let margin = margin * axis.direction.length();
                let on = [corner, corner + a, corner + b].map(|point| point.dot(axis.direction));
                on.iter().all(|&on| on > axis.high + margin) || on.iter().all(|&on| on < axis.low - margin)
            });
            if apart {
                return (Stop::Edges, Relation::Misses);
            }
        }
        (Stop::Hit, Relation::Crosses)
    }
}

/// The corners of a square grid of points, given row by row. For other counts, the points at the same positions.
fn corner_points(points: &[DVec3]) -> impl Iterator<Item = &DVec3> {
    let side = points.len().isqrt().max(1);
    let mut corners = vec![0, side - 1, points.len().saturating_sub(side), points.len().saturating_sub(1)];
    corners.dedup();
    corners.into_iter().filter_map(|at| points.get(at))
}
