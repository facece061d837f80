//! The AFF reader on the BART kitchen and robot: numbers measured by an independent reader, written in another
//! language, on the same files.

use std::path::Path;

use glam::Vec3;
use umbrasim::scene::{Geometry, Scene, Triangle, aff};

/// The scene, or `None` with a note where the files are not at hand.
fn load(file: &str) -> Option<Scene> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/scenes/bart")).join(file);
    if path.exists() {
        Some(aff::load(&path).unwrap())
    } else {
        println!("skipped: {} is absent", path.display());
        None
    }
}

fn bounds<'a>(triangles: impl IntoIterator<Item = &'a Triangle>) -> (Vec3, Vec3) {
    let corners = triangles.into_iter().flat_map(|triangle| triangle.v);
    corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

fn assert_near(found: (Vec3, Vec3), expected: ([f32; 3], [f32; 3]), tolerance: f32) {
    let (low, high) = (Vec3::from(expected.0), Vec3::from(expected.1));
    assert!(
        found.0.abs_diff_eq(low, tolerance) && found.1.abs_diff_eq(high, tolerance),
        "{found:?} is not {expected:?}"
    );
}

fn zero_areas(geometry: &Geometry) -> usize {
    geometry.triangles.iter().filter(|triangle| triangle.normal() == Vec3::ZERO).count()
}

fn transmitting(scene: &Scene, geometry: &Geometry) -> usize {
    let materials = geometry.attributes.iter().map(|attributes| &scene.materials[attributes.material.0 as usize]);
    materials.filter(|material| material.transmittance > 0.0).count()
}

fn moved(before: &Geometry, after: &Geometry) -> usize {
    before.triangles.iter().zip(&after.triangles).filter(|(a, b)| a != b).count()
}

/// Mean distance and mean turn in degrees of the camera between neighbouring frames.
fn camera_speed(scene: &Scene, frames: std::ops::Range<u32>) -> (f64, f64) {
    let cameras: Vec<_> = frames.map(|number| scene.animation.frame(number).camera).collect();
    let steps = (cameras.len() - 1) as f64;
    let pairs = || cameras.windows(2);
    let turn = |a: glam::DVec3, b: glam::DVec3| a.cross(b).length().atan2(a.dot(b)).to_degrees();
    (
        pairs().map(|pair| pair[0].eye.distance(pair[1].eye)).sum::<f64>() / steps,
        pairs().map(|pair| turn(pair[0].forward, pair[1].forward)).sum::<f64>() / steps,
    )
}

#[test]
fn kitchen_is_as_measured() {
    let Some(scene) = load("kitchen/aff/kitchen.aff") else { return };
    let first = scene.animation.frame(0);
    assert_eq!(scene.name, "kitchen");
    assert_eq!((scene.primitive_count(), scene.dynamic_count), (110_561, 7_218));
    assert_eq!((scene.light_count, first.lights.len(), scene.frame_count), (6, 6, 800));
    assert_eq!(scene.background, Vec3::new(0.5, 0.5, 1.0));
    assert_eq!(scene.ambient, Vec3::splat(2.5));
    assert_eq!(scene.textures.len(), 8);
    assert_near(bounds(&scene.statics.triangles), ([-2.0, -1.1, -3.75], [6.0, 2.9, 4.33]), 0.005);
    assert_eq!(transmitting(&scene, &scene.statics) + transmitting(&scene, &first.dynamic), 19_128);
    println!("zero areas {} {}", zero_areas(&scene.statics), zero_areas(&first.dynamic));
    println!("speed {:?} {:?}", camera_speed(&scene, 1..61), camera_speed(&scene, 0..800));
    let mut car = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for number in 0..800 {
        let frame = scene.animation.frame(number);
        let (low, high) = bounds(&frame.dynamic.triangles);
        car = (car.0.min(low), car.1.max(high));
    }
    println!("car {car:?}");
    for number in [60, 119, 120, 121] {
        println!("{number} moved {}", moved(&first.dynamic, &scene.animation.frame(number).dynamic));
    }
}

#[test]
fn robot_is_as_measured() {
    let Some(scene) = load("robot/aff/Robot.aff") else { return };
    let first = scene.animation.frame(0);
    assert_eq!(scene.name, "robot");
    assert_eq!((scene.primitive_count(), scene.dynamic_count), (71_708, 62_490));
    println!("lights {} frames {}", scene.light_count, scene.frame_count);
    println!("static {:?}", bounds(&scene.statics.triangles));
    println!("trans {} {}", transmitting(&scene, &scene.statics), transmitting(&scene, &first.dynamic));
    println!("zero areas {} {}", zero_areas(&scene.statics), zero_areas(&first.dynamic));
    println!("speed {:?} {:?}", camera_speed(&scene, 1..61), camera_speed(&scene, 0..800));
    let start = std::time::Instant::now();
    let mut all = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for number in 0..800 {
        let frame = scene.animation.frame(number);
        let (low, high) = bounds(&frame.dynamic.triangles);
        all = (all.0.min(low), all.1.max(high));
    }
    println!("all {all:?} {:?}", start.elapsed() / 800);
    for number in [0, 100, 300, 500, 600, 700, 790] {
        let [a, b] = [number, number + 1].map(|n| scene.animation.frame(n));
        println!("{number} moved {}", moved(&a.dynamic, &b.dynamic));
    }
}
