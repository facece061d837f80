//! Certificates against the very rays that they speak for: triangles that graze a shaft by a few units in the last
//! place, at all scales, far from the origin, and at the receiver itself.

use glam::{DVec3, Vec2, Vec3};
use proptest::prelude::*;
use umbrasim::accel::Record;
use umbrasim::accel::{Ray, Relation, Shaft};
use umbrasim::culling::cells::{Cell, Inside, Receiver};
use umbrasim::quantity::PrimitiveId;
use umbrasim::scene::Triangle;
use umbrasim::scene::lamps::rectangle;

const NOBODY: PrimitiveId = PrimitiveId(0);

fn point() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0f64, -1.0..1.0, -1.0..1.0].prop_map(DVec3::from_array)
}

fn points<const N: usize>() -> impl Strategy<Value = [DVec3; N]> {
    proptest::collection::vec(point(), N).prop_map(|points| points.try_into().expect("as many as asked for"))
}

/// Takes the unit scene to where rounding is worse.
#[derive(Clone, Copy, Debug)]
struct Frame {
    scale: f64,
    shift: DVec3,
}

impl Frame {
    fn place(self, point: DVec3) -> Vec3 {
        ((point + self.shift) * self.scale).as_vec3()
    }
}

fn frame() -> impl Strategy<Value = Frame> {
    (-6..=9i32, point(), prop_oneof![Just(0.0), Just(1.0), Just(1e3), Just(1e5)])
        .prop_map(|(exponent, shift, far)| Frame { scale: 10f64.powi(exponent), shift: shift * far })
}

fn nudged(v: Vec3, ulps: [i32; 3]) -> Vec3 {
    let nudge = |value: f32, ulps: i32| {
        (0..ulps.abs()).fold(value, |value, _| if ulps > 0 { value.next_up() } else { value.next_down() })
    };
    Vec3::new(nudge(v.x, ulps[0]), nudge(v.y, ulps[1]), nudge(v.z, ulps[2]))
}

/// A piece of a receiver, and a light.
struct Stage {
    record: Record,
    corners: [Vec3; 3],
    cell: Cell,
    outside: bool,
    offset: f32,
    /// The points of the lamp.
    lights: Vec<Vec3>,
}

impl Stage {
    fn shaft(&self) -> Shaft {
        Receiver { record: &self.record, offset: self.offset }.shaft(self.cell, self.outside, &self.lights)
    }

    /// Where the tracer starts a shadow ray.
    fn start(&self, Vec2 { x: u, y: v }: Vec2) -> Vec3 {
        let [a, b, c] = self.corners;
        let normal = Triangle { v: self.corners }.normal().normalize();
        a + (b - a) * u + (c - a) * v + if self.outside { normal } else { -normal } * self.offset
    }

    /// The cell's corners as barycentric coordinates, by bisection along its path.
    fn barycentric(&self) -> [Vec2; 3] {
        let border = 1.0 / 1024.0;
        let mut corners =
            [Vec2::splat(border), Vec2::new(1.0 - 2.0 * border, border), Vec2::new(border, 1.0 - 2.0 * border)];
        for step in self.cell.path() {
            let [a, b, c] = corners;
            let (ab, bc, ca) = ((a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5);
            corners = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]][step as usize];
        }
        corners
    }

    /// Rays of the cell: from its corners, its edges and within, where the hit's coordinates fall into it.
    fn rays(&self, weights: &[[f32; 2]]) -> Vec<Ray> {
        let [a, b, c] = self.barycentric();
        let rims = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]];
        let hits = rims.iter().chain(weights).map(|&[u, v]| {
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            a + (b - a) * u + (c - a) * v
        });
        let inside = |&hit: &Vec2| {
            let mut at = Inside::whole(hit)?;
            let mut cell = Cell::whole(NOBODY);
            for _ in 0..self.cell.level() {
                let (child, within) = at.descend();
                (cell, at) = (cell.child(child), within);
            }
            (cell == self.cell).then_some(())
        };
        let starts = hits.filter(|hit| inside(hit).is_some()).map(|hit| self.start(hit));
        starts.flat_map(|start| self.lights.iter().map(move |&light| Ray::segment(start, light))).collect()
    }
}

#[derive(Clone, Copy, Debug)]
enum Blocker {
    /// Anywhere.
    Free([DVec3; 3]),
    /// An edge through a point of the ray from one corner of the cell.
    Grazing { corner: usize, along: f64, edge: DVec3, third: DVec3, size: f64 },
    /// Around the section of the shaft, larger by a factor, its plane tilted.
    Around { along: f64, excess: f64, tilt: DVec3 },
    /// On an edge of the receiver.
    Neighbour { corner: usize, third: DVec3 },
    /// In the receiver's plane.
    Coplanar { along: [f64; 2] },
}

fn blocker() -> impl Strategy<Value = Blocker> {
    let excess =
        (-8.0..0.5f64, proptest::bool::ANY).prop_map(|(e, more)| 10f64.powf(e) * if more { 1.0 } else { -1.0 });
    prop_oneof![
        points().prop_map(Blocker::Free),
        (0..3usize, 0.0..1.0f64, point(), point(), 0.0..5.0f64).prop_map(|(corner, along, edge, third, size)| {
            Blocker::Grazing { corner, along, edge, third, size: 10f64.powf(size) }
        }),
        (0.01..0.99f64, excess, point()).prop_map(|(along, excess, tilt)| Blocker::Around { along, excess, tilt }),
        (0..3usize, point()).prop_map(|(corner, third)| Blocker::Neighbour { corner, third }),
        [-2.0..2.0f64, -2.0..2.0].prop_map(|along| Blocker::Coplanar { along }),
    ]
}

impl Blocker {
    /// The triangle; `starts` are those of the rays from the cell's corners, all in world space.
    fn triangle(self, stage: &Stage, frame: Frame) -> Triangle {
        let light = stage.lights[0].as_dvec3();
        let starts = stage.barycentric().map(|hit| stage.start(hit).as_dvec3());
        let size = frame.scale;
        let v = match self {
            Self::Free(v) => v.map(|v| frame.place(v)),
            Self::Grazing { corner, along, edge, third, size: larger } => {
                let size = size * larger;
                let p = starts[corner].lerp(light, along);
                [p + edge * size, p - edge * size, p + third * size].map(|v| v.as_vec3())
            }
            Self::Around { along, excess, tilt } => {
                let section = starts.map(|start| start.lerp(light, along));
                let center = (section[0] + section[1] + section[2]) / 3.0;
                let grow = |corner: DVec3| {
                    let grown = center + (corner - center) * (1.0 + excess);
                    // Along the ray through it, so that what is seen from the light stays the same.
                    grown + (grown - light) * tilt.dot((corner - center).normalize_or_zero()) * 0.3 * (1.0 - along)
                };
                section.map(|corner| grow(corner).as_vec3())
            }
            Self::Neighbour { corner, third } => {
                let [a, b] = [stage.corners[corner], stage.corners[(corner + 1) % 3]];
                [a, b, (a.as_dvec3() + third * size).as_vec3()]
            }
            Self::Coplanar { along } => {
                let [a, b, c] = stage.corners;
                [b, c, a + (b - a) * along[0] as f32 + (c - a) * along[1] as f32]
            }
        };
        Triangle { v }
    }
}

/// How often each answer was given, that no test passes by certifying nothing.
#[derive(Default, Debug)]
struct Answers {
    misses: u32,
    covers: u32,
    crosses: u32,
    /// Those of them of lamps of several points.
    area_misses: u32,
    area_covers: u32,
}

#[test]
fn a_certificate_holds_for_every_ray() {
    let mut runner = proptest::test_runner::TestRunner::new_with_rng(
        ProptestConfig { cases: 60_000, failure_persistence: None, ..ProptestConfig::default() },
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    );
    let answers = std::cell::RefCell::new(Answers::default());
    let weights = proptest::collection::vec([0.0..1.0f32, 0.0..1.0], 24);
    let path = proptest::collection::vec(0..4u32, 0..7);
    let offset = prop_oneof![Just(1e-5), Just(1e-4), Just(1e-3), Just(0.0)];
    let nudges = proptest::collection::vec([-3..=3i32, -3..=3, -3..=3], 3);
    let lamp = (1..4usize, points::<2>(), -4.0..0.0f64);
    let lamp = lamp.prop_map(|(side, half, size)| (side, half.map(|half| half * 10f64.powf(size))));
    let setting =
        (frame(), points::<3>(), (point(), lamp), path, offset, blocker(), nudges, weights, proptest::bool::ANY);
    let result = runner.run(&setting, |(frame, receiver, lamp, path, offset, blocker, nudges, weights, outside)| {
        let (light, (side, half)) = lamp;
        let corners = receiver.map(|corner| frame.place(corner));
        let triangle = Triangle { v: corners };
        prop_assume!(triangle.normal().try_normalize().is_some());
        let cell = path.iter().fold(Cell::whole(NOBODY), |cell, &step| cell.child(step));
        let stage = Stage {
            record: Record::new(&triangle, NOBODY),
            corners,
            cell,
            outside,
            offset: (offset * frame.scale) as f32,
            lights: rectangle(light * 3.0, half, side, Vec3::ONE)
                .map(|light| frame.place(light.position.as_dvec3()))
                .collect(),
        };
        let mut other = blocker.triangle(&stage, frame);
        for (corner, ulps) in other.v.iter_mut().zip(nudges) {
            *corner = nudged(*corner, ulps);
        }
        let other = Record::new(&other, NOBODY);
        let (_, relation) = stage.shaft().relation(&other);
        let rays = stage.rays(&weights);
        let mut answers = answers.borrow_mut();
        let area = u32::from(stage.lights.len() > 1);
        match relation {
            Relation::Misses => {
                answers.misses += 1;
                answers.area_misses += area;
            }
            Relation::Covers => {
                answers.covers += 1;
                answers.area_covers += area;
            }
            Relation::Crosses => answers.crosses += 1,
        }
        for ray in rays {
            let (_, blocked) = other.blocks(&ray);
            prop_assert!(relation != Relation::Misses || !blocked, "{ray:?} is blocked");
            prop_assert!(relation != Relation::Covers || blocked, "{ray:?} is not blocked");
        }
        Ok(())
    });
    let answers = answers.into_inner();
    result.unwrap_or_else(|failure| panic!("{failure}"));
    println!("{answers:?}");
    assert!(answers.misses > 5_000 && answers.covers > 1_000 && answers.crosses > 5_000, "{answers:?}");
    assert!(answers.area_misses > 5_000 && answers.area_covers > 500, "{answers:?}");
}

#[test]
fn a_certain_blocker_is_found_by_the_tree() {
    let mut runner = proptest::test_runner::TestRunner::new_with_rng(
        ProptestConfig { cases: 100_000, failure_persistence: None, ..ProptestConfig::default() },
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    );
    let counts = std::cell::Cell::new([0u32; 3]);
    let graze = (0.0..1.0f64, -40..=40i32, -5.0..0.0f64, proptest::bool::ANY);
    let setting = (frame(), points::<3>(), point(), graze);
    let result = runner.run(&setting, |(frame, corners, away, (at, ulps, near, flat))| {
        // Flat, and hit at a corner: there the box has no room to spare.
        let flatten = |corner: DVec3| if flat { DVec3 { z: corners[0].z, ..corner } } else { corner };
        let at = if flat { 1.0 } else { at };
        let v = corners.map(flatten);
        let v = v.map(|corner| frame.place(corner));
        let record = Record::new(&Triangle { v }, NOBODY);
        // Through a point of an edge, or some units in the last place beside it.
        let edge = v[0].as_dvec3().lerp(v[1].as_dvec3(), at);
        let edge = nudged(edge.as_vec3(), [ulps, 0, -ulps]).as_dvec3();
        // From near by, as where a large triangle touches the ground: the corner is far away, and its rounding large.
        let origin = (edge + away * frame.scale * 10f64.powf(near)).as_vec3();
        let target = origin.as_dvec3() + (edge - origin.as_dvec3()) * 2.0 * 10f64.powf(-near);
        let ray = Ray::segment(origin, target.as_vec3());
        let (low, high) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
        let bounds = [0, 1, 2].map(|axis| [[low[axis]], [high[axis]]]);
        let in_box = ray.entries(&bounds)[0] < f32::INFINITY;
        let (blocks, surely) = (record.blocks(&ray).1, record.surely_blocks(&ray).1);
        let [all, sure, missed] = counts.get();
        counts.set([all + u32::from(blocks), sure + u32::from(surely), missed + u32::from(blocks && !in_box)]);
        prop_assert!(!surely || blocks && in_box, "{ray:?} on {v:?}");
        Ok(())
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    let [blocks, surely, missed] = counts.get();
    println!(
        "{blocks} rays are blocked, {surely} surely; {missed} by a triangle in whose box the slab test does not find them"
    );
    assert!(surely > 5_000, "{surely} of {blocks}");
}
