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

/// To the last digit of the numbers as measured.
fn assert_speed(found: (f64, f64), expected: (f64, f64)) {
    let same = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.025;
    assert!(same(found.0, expected.0) && same(found.1, expected.1), "{found:?} is not {expected:?}");
}

/// The box of all that can move, over the whole run.
fn dynamic_bounds(scene: &Scene) -> (Vec3, Vec3) {
    let boxes = (0..scene.frame_count).map(|number| bounds(&scene.animation.frame(number).dynamic.triangles));
    boxes.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |all, one| (all.0.min(one.0), all.1.max(one.1)))
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
    assert_eq!(zero_areas(&scene.statics) + zero_areas(&first.dynamic), 41);
    assert_speed(camera_speed(&scene, 1..61), (0.020, 0.77));
    assert_speed(camera_speed(&scene, 0..800), (0.018, 1.19));
    let car = dynamic_bounds(&scene);
    assert_near(car, ([1.20, 0.0, 0.13], [4.58, 0.14, 3.72]), 0.006);
    // The toy car waits until 3.0 s: the time of frame 120 is the first after it.
    assert_eq!(moved(&first.dynamic, &scene.animation.frame(119).dynamic), 0);
    assert_eq!(moved(&first.dynamic, &scene.animation.frame(120).dynamic), 7_218);
}

#[test]
fn robot_is_as_measured() {
    let Some(scene) = load("robot/aff/Robot.aff") else { return };
    let first = scene.animation.frame(0);
    assert_eq!(scene.name, "robot");
    assert_eq!((scene.primitive_count(), scene.dynamic_count), (71_708, 62_490));
    assert_eq!((scene.light_count, first.lights.len(), scene.frame_count), (1, 1, 800));
    assert_eq!((scene.background, scene.ambient), (Vec3::ZERO, Vec3::ONE));
    assert_near(bounds(&scene.statics.triangles), ([-164.1, 0.0, -435.4], [164.1, 535.4, 250.1]), 0.05);
    assert_eq!(transmitting(&scene, &scene.statics) + transmitting(&scene, &first.dynamic), 1_516);
    assert_eq!(zero_areas(&scene.statics) + zero_areas(&first.dynamic), 128);
    assert_speed(camera_speed(&scene, 1..61), (0.059, 0.079));
    assert_speed(camera_speed(&scene, 0..800), (0.68, 0.763));
    assert_near(dynamic_bounds(&scene), ([-58.8, -0.65, -239.8], [58.8, 11.5, 158.9]), 0.05);
    for (number, count) in [(0, 62_490), (100, 62_490), (300, 62_490), (600, 62_490), (700, 43_572), (790, 6_927)] {
        let [before, after] = [number, number + 1].map(|number| scene.animation.frame(number).dynamic);
        assert_eq!(moved(&before, &after), count, "frame {number}");
    }
}

#[test]
fn frames_are_the_same_on_any_number_of_threads() {
    let Some(scene) = load("robot/aff/Robot.aff") else { return };
    let frame = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scene.animation.frame(400)).dynamic
    };
    assert_eq!(frame(1), frame(3));
}
