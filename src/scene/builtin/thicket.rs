//! Grass and leaves of many small triangles, with balls that bounce: a stress test. Metres.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DQuat, DVec3, Vec3, dvec3, vec3};

use super::made::Made;
use super::paint::{Palette, share};
use super::shapes::{Shapes, hash};
use crate::scene::camera::Camera;
use crate::scene::material::MaterialId;
use crate::scene::parts::{Part, Parts};

/// Half the side of the ground.
const HALF: f64 = 4.0;

const LAMPS: [(Vec3, Vec3); 6] = [
    (vec3(-6.0, 7.0, 3.0), vec3(1.0, 0.93, 0.8)),
    (vec3(5.0, 4.5, -2.0), vec3(0.7, 0.8, 1.0)),
    (vec3(0.0, 9.0, 0.0), vec3(1.0, 1.0, 0.95)),
    (vec3(4.0, 3.0, 5.0), vec3(1.0, 0.8, 0.7)),
    (vec3(-5.0, 2.5, -5.0), vec3(0.8, 0.9, 1.0)),
    (vec3(0.0, 3.0, 7.0), vec3(0.9, 0.9, 0.9)),
];

/// The thicket: `triangles` are shared by grass, and by plants of broad leaves.
pub(super) fn build(lights: usize, triangles: usize) -> Made {
    let mut palette = Palette::default();
    let mut shapes = Shapes::default();
    ground(&mut shapes, &mut palette);
    let grass: Vec<MaterialId> = (0..5)
        .map(|i| {
            let s = i as f32 / 4.0;
            palette.matt(0.16 + 0.3 * s, 0.36 + 0.2 * s, 0.1 + 0.06 * s)
        })
        .collect();
    let leaf = [palette.matt(0.12, 0.36, 0.12), palette.matt(0.5, 0.15, 0.2), palette.matt(0.36, 0.5, 0.14)];
    // More blades and leaves are smaller, so that they cover about the same share of the ground.
    let scale = (1e5 / triangles as f64).sqrt().clamp(0.2, 2.0);
    let width = 0.02 * scale;
    let cards = triangles / 10;
    for blade in 0..(triangles - cards) as u64 {
        let random = |what: u64| hash(blade * 8 + what);
        let root = spot(random(0), random(1));
        let (sin, cos) = (TAU * random(2)).sin_cos();
        let tall = (0.12 + 0.3 * random(3) * random(4)) * (0.7 + 0.5 * meadow(root));
        let lean = tall * (0.2 + 0.5 * random(5));
        let side = dvec3(-sin, 0.0, cos) * width * 0.5;
        shapes.paint(grass[(random(6) * 5.0) as usize]);
        shapes.triangle([root - side, root + side, root + dvec3(cos * lean, tall, sin * lean)]);
    }
    // Plants of 48 leaves each, all from one root.
    for card in 0..cards as u64 {
        let plant = |what: u64| hash((1 << 40) + (card / 48) * 4 + what);
        let random = |what: u64| hash((1 << 41) + card * 4 + what);
        let (root, size) = (spot(plant(0), plant(1)), (0.2 + 0.22 * plant(2)) * scale);
        let turn = DQuat::from_rotation_y(TAU * random(0));
        let (rise, long) = (0.5 + 1.1 * random(1), size * (0.5 + 0.5 * random(2)));
        let at = |s: f64, side: f64| root + turn * dvec3(s * long, s * long * rise, side * long * 0.13);
        shapes.paint(leaf[(plant(3) * 3.0) as usize]);
        shapes.triangle([at(0.3, -1.0), at(0.3, 1.0), at(1.0, 0.0)]);
    }
    let parts = balls(&mut palette);
    let camera = |frame: u32| {
        // The camera circles slowly around the middle.
        let angle = 0.9 + 0.004 * f64::from(frame);
        let eye = dvec3(4.4 * angle.cos(), 2.0, 4.4 * angle.sin());
        Camera::perspective(eye, dvec3(0.0, 0.45, 0.0) - eye, DVec3::Y, 45f64.to_radians())
    };
    Made {
        statics: shapes.geometry,
        parts: Parts { parts, lights: share(&LAMPS, lights, 1.5), carried: Vec::new(), camera: Box::new(camera) },
        palette,
        background: vec3(0.62, 0.76, 0.92),
        ambient: vec3(0.24, 0.28, 0.3),
    }
}

/// The height of the ground.
fn height(x: f64, z: f64) -> f64 {
    0.16 * (1.1 * x + 0.4).sin() * (0.9 * z).cos() + 0.06 * (2.3 * x - 1.7 * z).sin()
}

/// The point of the ground for two numbers from 0 to 1.
fn spot(s: f64, t: f64) -> DVec3 {
    let (x, z) = (HALF * (2.0 * s - 1.0), HALF * (2.0 * t - 1.0));
    dvec3(x, height(x, z), z)
}

/// How tall the grass is, from short (0) to tall (1).
fn meadow(at: DVec3) -> f64 {
    0.5 + 0.5 * (1.9 * at.x).sin() * (1.4 * at.z + 1.0).sin()
}

/// Rolling soil, under the grass.
fn ground(shapes: &mut Shapes, palette: &mut Palette) {
    const TILES: u32 = 48;
    let soil = palette.matt(0.3, 0.23, 0.15);
    shapes.paint(soil);
    let at = |i: u32, j: u32| spot(f64::from(i) / f64::from(TILES), f64::from(j) / f64::from(TILES));
    for j in 0..TILES {
        for i in 0..TILES {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            shapes.triangle([a, b, c]);
            shapes.triangle([a, c, d]);
        }
    }
}

/// Balls that bounce along circles: a mirror, one of glass, one with a pattern, two plain ones.
fn balls(palette: &mut Palette) -> Vec<Part> {
    let paints = [
        (palette.mirror(), 0.42),
        (palette.checker(8, [[214, 62, 48], [240, 232, 214]], 0.1), 0.34),
        (palette.glass(), 0.3),
        (palette.glossy(0.9, 0.7, 0.15), 0.22),
        (palette.glossy(0.2, 0.35, 0.75), 0.26),
    ];
    let ball = |(index, (paint, radius)): (usize, (MaterialId, f64))| {
        let mut shapes = Shapes { material: paint, ..Shapes::default() };
        shapes.sphere(DVec3::ZERO, radius, 32);
        let share = index as f64 / 5.0;
        let pose = move |frame: u32| {
            let t = f64::from(frame);
            let angle = TAU * share + t * 0.008;
            let around = if index % 2 == 0 { 1.0 } else { 1.6 };
            let (x, z) = (around * angle.cos(), around * angle.sin());
            // A bounce is a parabola: 40 frames and at most 0.8 m high.
            let u = (t / 40.0 + 2.6 * share).fract();
            let y = height(x, z) + radius + 0.12 + 0.8 * 4.0 * u * (1.0 - u);
            DAffine3::from_rotation_translation(DQuat::from_rotation_x(PI * t / 60.0), dvec3(x, y, z))
        };
        Part { geometry: shapes.geometry, pose: Box::new(pose) }
    };
    paints.into_iter().enumerate().map(ball).collect()
}
