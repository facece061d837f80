//! The renderer against a test of every triangle: exactly the same hits and the same shadows.

use glam::{DVec2, DVec3, Vec3};
use proptest::prelude::*;

use super::{OFFSET, scene, spec, window};
use crate::quantity::{PrimitiveId, Resolution};
use crate::reference::ray::Ray;
use crate::reference::{Hit, Reference, bvh};
use crate::scene::{Attributes, Camera, Frame, Geometry, Material, Scene, ShadowBits, ShadowRays, Triangle};

/// The nearest hit, from a test of every triangle.
fn closest_of_all(scene: &Scene, frame: &Frame, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let ray = Ray::new(origin, direction, 0.0);
    let hits = hittable(scene, frame).filter_map(|primitive| {
        let crossing = ray.meet(scene.triangle(frame, primitive))?;
        (crossing.t > 0.0).then_some(Hit { t: crossing.t, primitive, weights: crossing.weights })
    });
    hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)))
}

fn hittable(scene: &Scene, frame: &Frame) -> impl Iterator<Item = PrimitiveId> {
    (0..scene.primitive_count())
        .filter(|index| index.checked_sub(scene.statics.len()).is_none_or(|moving| frame.visible[moving]))
        .map(|index| PrimitiveId(index as u32))
        .filter(|primitive| bvh::can_be_hit(scene.triangle(frame, *primitive)))
}

/// The shadows of a hit, from a test of every triangle.
fn shadows_of_all(scene: &Scene, frame: &Frame, ray: (DVec3, DVec3), hit: &Hit, rays: ShadowRays) -> ShadowBits {
    let [a, b, c] = scene.triangle(frame, hit.primitive).v.map(|corner| corner.as_dvec3());
    let normal = (b - a).cross(c - a).normalize();
    let normal = if normal.dot(ray.1) < 0.0 { normal } else { -normal };
    let point = ray.0 + hit.t * ray.1;
    let start = point + OFFSET * normal;
    let mut bits = ShadowBits::default();
    for (light, at) in frame.lights.iter().enumerate() {
        let position = at.position.as_dvec3();
        if rays == ShadowRays::Always || (position - point).dot(normal) > 0.0 {
            let segment = Ray::new(start, position - start, 0.0);
            let dark = hittable(scene, frame).any(|primitive| {
                segment.meet(scene.triangle(frame, primitive)).is_some_and(|at| 0.0 < at.t && at.t < 1.0)
            });
            bits.asked |= 1 << light;
            bits.dark |= u64::from(dark) << light;
        }
    }
    bits
}

/// Corners on a coarse grid, so that many triangles coincide, touch or have no area; or at random positions.
fn soup(count: usize) -> impl Strategy<Value = Vec<[Vec3; 3]>> {
    let corner = |grid: bool| {
        prop::array::uniform3(-1.0f32..1.0)
            .prop_map(move |v| if grid { (Vec3::from(v) * 4.0).round() / 4.0 } else { Vec3::from(v) })
    };
    let some = move |grid| prop::collection::vec(prop::array::uniform3(corner(grid)), 0..count);
    prop_oneof![some(true), some(false)]
}

fn geometry(triangles: &[[Vec3; 3]]) -> Geometry {
    let mut geometry = Geometry::default();
    triangles.iter().for_each(|v| geometry.push(Triangle { v: *v }, Attributes::default()));
    geometry
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn equals_brute_force(
        statics in soup(60),
        moving in soup(20),
        hidden in prop::collection::vec(any::<bool>(), 20),
        lights in prop::collection::vec(prop::array::uniform3(-2.0f32..2.0), 0..4),
        tilt in prop::array::uniform2(-1.0f64..1.0),
        straight in any::<bool>(),
        always in any::<bool>(),
    ) {
        // 16 pixels on 2 units, shifted by half a pixel: straight rays run through grid corners and along box sides.
        let tilt = if straight { [0.0; 2] } else { tilt };
        let camera = Camera { jitter: DVec2::splat(0.5), ..window(2.0, DVec3::new(tilt[0], tilt[1], -1.0)) };
        let lights: Vec<Vec3> = lights.into_iter().map(Vec3::from).collect();
        let scene = scene(geometry(&statics), geometry(&moving), vec![Material::default()], &lights, camera);
        let mut frame = scene.animation.frame(0);
        frame.visible.iter_mut().zip(&hidden).for_each(|(visible, hidden)| *visible = !hidden);
        let rays = if always { ShadowRays::Always } else { ShadowRays::ViewerSide };
        let resolution = Resolution { width: 16, height: 16 };
        let picture = Reference::new(&scene).render(&frame, resolution, &spec(1, rays), OFFSET);
        for y in 0..16 {
            for x in 0..16 {
                let pixel = resolution.pixel(x, y).0 as usize;
                let ray = camera.ray(resolution, x, y);
                let hit = closest_of_all(&scene, &frame, ray.origin, ray.direction);
                prop_assert_eq!(picture.hits[pixel], hit.map(|hit| hit.primitive));
                let shadows = hit.map_or(ShadowBits::default(), |hit| {
                    shadows_of_all(&scene, &frame, (ray.origin, ray.direction), &hit, rays)
                });
                prop_assert_eq!(picture.shadows[pixel], shadows);
            }
        }
    }

    #[test]
    fn closest_equals_brute_force(triangles in soup(200), o in prop::array::uniform3(-3.0f64..3.0), k in -8i32..=8) {
        let camera = window(2.0, DVec3::NEG_Z);
        let scene = scene(geometry(&triangles), Geometry::default(), vec![Material::default()], &[], camera);
        let frame = scene.animation.frame(0);
        let reference = Reference::new(&scene);
        let traced = reference.frame(&frame);
        let origin = DVec3::from(o);
        let towards = DVec3::splat(f64::from(k) / 8.0);
        for target in [towards, DVec3::X * towards.x, DVec3::ZERO, origin + DVec3::Y, origin] {
            let direction = target - origin;
            prop_assert_eq!(traced.closest(origin, direction), closest_of_all(&scene, &frame, origin, direction));
        }
    }
}
