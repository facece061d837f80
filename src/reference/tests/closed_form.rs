//! The renderer against pictures of which every pixel is known.

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::{OFFSET, add_rectangle, glow, render, samples, scene, spec, window};
use crate::scene::{Camera, Geometry, Material, RenderSpec, ShadowBits, ShadowRays, Texture, TextureId};

/// A floor below a blocker: its shadow is the blocker projected from the light, so every pixel is known.
#[test]
fn shadow_of_a_rectangle() {
    let (low, high, height) = ([-0.3f32, -0.1], [0.5f32, 0.4], 2.0f32);
    let light = Vec3::new(0.25, -0.75, 6.0);
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-2.0; 2], [2.0; 2], 0.0, 0);
    add_rectangle(&mut statics, low, high, height, 0);
    let camera = window(1.0, DVec3::NEG_Z);
    let scene = scene(statics, Geometry::default(), vec![Material::default()], &[light], camera);
    let picture = render(&scene, &spec(1, ShadowRays::ViewerSide));
    // The share of its way that a ray from the start point has covered at the blocker's height.
    let share = (f64::from(height) - OFFSET) / (f64::from(light.z) - OFFSET);
    let mut dark_pixels = 0;
    for (pixel, x, y) in samples(&camera) {
        let at = DVec2::new(x, y).lerp(light.truncate().as_dvec2(), share);
        let inside = |at: f64, axis: usize| f64::from(low[axis]) < at && at < f64::from(high[axis]);
        let dark = inside(at.x, 0) && inside(at.y, 1);
        assert_eq!(picture.shadows[pixel], ShadowBits { asked: 1, dark: u64::from(dark) }, "{x} {y}");
        let to_light = (light.as_dvec3() - DVec3::new(x, y, 0.0)).normalize();
        let expected = 0.1 + if dark { 0.0 } else { 0.7 * to_light.z };
        assert!((f64::from(picture.rgb[pixel].x) - expected).abs() < 1e-6);
        dark_pixels += u32::from(dark);
    }
    // Enlarged 1.5 times from the light: 38 columns of samples in -0.575..0.625, 24 rows in 0.225..0.975.
    assert_eq!(dark_pixels, 38 * 24);
}

#[test]
fn highlight_of_a_corner_normal() {
    let light = Vec3::new(0.0, 0.0, 3.0);
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-2.0; 2], [2.0; 2], 0.0, 0);
    // Tilted by 30 degrees and turned to the wrong side, which must not change the result.
    let tilted = -Vec3::new(0.5, 0.0, 0.75f32.sqrt());
    statics.attributes.iter_mut().for_each(|attributes| attributes.normals = Some([tilted; 3]));
    let material = Material { specular: Vec3::splat(0.2), shininess: 8.0, ..Material::default() };
    let camera = window(1.0, DVec3::NEG_Z);
    let mut scene = scene(statics, Geometry::default(), vec![material], &[light], camera);
    let picture = render(&scene, &spec(1, ShadowRays::ViewerSide));
    for (pixel, x, y) in samples(&camera) {
        let (to_light, n) = ((light.as_dvec3() - DVec3::new(x, y, 0.0)).normalize(), -tilted.as_dvec3());
        let cosine = n.dot(to_light);
        let mirrored = (2.0 * cosine * n - to_light).z;
        let expected = 0.1 + 0.7 * cosine + 0.2 * mirrored.max(0.0).powi(8);
        assert!((f64::from(picture.rgb[pixel].y) - expected).abs() < 1e-6, "{x} {y}");
    }
    // Where normals cancel out, the geometric normal is used.
    scene.statics.attributes.iter_mut().for_each(|attributes| attributes.normals = Some([Vec3::ZERO; 3]));
    let flat = render(&scene, &spec(1, ShadowRays::ViewerSide));
    scene.statics.attributes.iter_mut().for_each(|attributes| attributes.normals = None);
    assert_eq!(flat, render(&scene, &spec(1, ShadowRays::ViewerSide)));
}

/// A glowing half-plane at z = 3, seen in a mirror floor: every pixel is known.
#[test]
fn mirror_image() {
    let mirror = Material { specular: Vec3::new(1.0, 0.5, 0.0), ..glow(Vec3::ZERO) };
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-2.0; 2], [2.0; 2], 0.0, 0);
    add_rectangle(&mut statics, [0.3, -90.0], [90.0, 90.0], 3.0, 1);
    let direction = DVec3::new(0.1, 0.2, -1.0);
    let camera = window(1.0, direction);
    let scene = scene(statics, Geometry::default(), vec![mirror, glow(Vec3::ONE)], &[], camera);
    let (direct, mirrored) =
        (render(&scene, &spec(1, ShadowRays::Always)), render(&scene, &spec(2, ShadowRays::Always)));
    // One unit down to the mirror and three up; the offset moves the start upwards only.
    let shift = direction.x * (1.0 + 3.0 - OFFSET);
    for (pixel, x, _) in samples(&camera) {
        let expected = if x + shift > f64::from(0.3f32) { mirror.specular } else { Vec3::ZERO };
        assert_eq!(direct.rgb[pixel], Vec3::ZERO);
        assert_eq!(mirrored.rgb[pixel], expected, "{x}");
        assert_eq!(mirrored.hits[pixel].map(|hit| hit.0 / 2), Some(0));
    }
    // A weight of 0.5 twice is 0.25: two mirrors face each other at z = 0 and 3, the third hit glows.
    let mut facing = scene;
    facing.materials[1] = Material { specular: Vec3::splat(0.5), ..glow(Vec3::ONE) };
    facing.materials[0] = Material { specular: Vec3::splat(0.5), ..glow(Vec3::ONE) };
    facing.statics = Geometry::default();
    add_rectangle(&mut facing.statics, [-90.0; 2], [90.0; 2], 0.0, 0);
    add_rectangle(&mut facing.statics, [-90.0; 2], [90.0; 2], 3.0, 1);
    for (depth, min_weight, sum) in [(3, 0.0, 1.75), (3, 0.25, 1.75), (3, 0.26, 1.5), (3, 0.6, 1.0), (5, 0.0, 1.9375)] {
        let picture = render(&facing, &RenderSpec { min_weight, ..spec(depth, ShadowRays::Always) });
        assert!(picture.rgb.iter().all(|rgb| *rgb == Vec3::splat(sum)), "{depth} {min_weight}");
    }
}

/// A water surface at z = 0 over a glowing half-plane at z = -2, seen along `direction` from `z`; another colour glows
/// at z = 2. Returns the colours and the camera.
fn water(direction: DVec3, z: f64, transmittance: f32) -> (Vec<Vec3>, Camera) {
    let surface = Material { transmittance, specular: Vec3::splat(0.25), index_of_refraction: 1.5, ..glow(Vec3::ZERO) };
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-90.0; 2], [90.0; 2], 0.0, 0);
    add_rectangle(&mut statics, [0.1, -90.0], [90.0, 90.0], -2.0, 1);
    add_rectangle(&mut statics, [0.1, -90.0], [90.0, 90.0], 2.0, 2);
    let camera = window(z, direction);
    let scene = scene(statics, Geometry::default(), vec![surface, glow(Vec3::X), glow(Vec3::Y)], &[], camera);
    (render(&scene, &spec(2, ShadowRays::ViewerSide)).rgb, camera)
}

#[test]
fn refraction_follows_snell() {
    let border = f64::from(0.1f32);
    // Down into the water with a sine of 0.6: below, the sine is 0.4. Up and out of it with 0.4: above, the sine is
    // 0.6.
    for (sine, direction_z, eye) in [(0.6f64, -1.0, 1.0), (0.4, 1.0, -1.0)] {
        let cosine = (1.0 - sine * sine).sqrt();
        let (colors, camera) = water(DVec3::new(sine, 0.0, direction_z * cosine), eye, 0.5);
        let bent: f64 = if direction_z < 0.0 { sine / 1.5 } else { sine * 1.5 };
        let tangent = sine / cosine;
        let bent_tangent = bent / (1.0 - bent * bent).sqrt();
        for (pixel, x, _) in samples(&camera) {
            let surface = x + tangent;
            let through = f64::from(u8::from(surface + (2.0 - OFFSET) * bent_tangent > border)) * 0.5;
            let back = f64::from(u8::from(surface + (2.0 - OFFSET) * tangent > border)) * 0.25;
            let expected = if direction_z < 0.0 { (through, back) } else { (back, through) };
            assert_eq!((f64::from(colors[pixel].x), f64::from(colors[pixel].y)), expected, "{x}");
        }
    }
}

#[test]
fn total_internal_reflection() {
    // From inside, a sine of 2/3 is the limit.
    for (sine, total) in [(0.66f64, false), (0.67, true)] {
        let (colors, _) = water(DVec3::new(sine, 0.0, (1.0 - sine * sine).sqrt()), -1.0, 0.5);
        let seen = colors.iter().fold(Vec3::ZERO, |all, color| all.max(*color));
        let expected = if total { Vec3::new(0.75, 0.0, 0.0) } else { Vec3::new(0.25, 0.5, 0.0) };
        assert_eq!(seen, expected);
    }
}

/// The back of a triangle, lit from its front: only `Always` asks for the light, and then the triangle itself blocks.
#[test]
fn lights_behind_the_surface() {
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-2.0; 2], [2.0; 2], 0.0, 0);
    let camera = window(1.0, DVec3::NEG_Z);
    let lights = [Vec3::new(0.3, 0.0, -4.0), Vec3::new(0.3, 0.0, 4.0)];
    let scene = scene(statics, Geometry::default(), vec![Material::default()], &lights, camera);
    let side = render(&scene, &spec(1, ShadowRays::ViewerSide));
    let always = render(&scene, &spec(1, ShadowRays::Always));
    assert!(side.shadows.iter().all(|bits| *bits == ShadowBits { asked: 2, dark: 0 }));
    assert!(always.shadows.iter().all(|bits| *bits == ShadowBits { asked: 3, dark: 1 }));
    assert_eq!(side.rgb, always.rgb);
}

/// A texture of 4 x 2 pixels, repeated twice across the window and once upwards.
#[test]
fn textures_lie_as_the_corners_say() {
    let rgb: Vec<[u8; 3]> = (0..8).map(|gray| [gray * 30; 3]).collect();
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-1.0; 2], [1.0; 2], 0.0, 0);
    for (triangle, attributes) in statics.triangles.iter().zip(&mut statics.attributes) {
        attributes.uv = triangle.v.map(|corner| Vec2::new(corner.x + 1.0, 0.5 * (corner.y + 1.0)));
    }
    let paper = Material { texture: Some(TextureId(0)), ..glow(Vec3::new(1.0, 0.5, 0.0)) };
    let camera = window(1.0, DVec3::NEG_Z);
    let mut scene = scene(statics, Geometry::default(), vec![paper], &[], camera);
    scene.textures = vec![Texture { width: 4, height: 2, rgb: rgb.clone() }];
    let picture = render(&scene, &spec(1, ShadowRays::ViewerSide));
    for (pixel, x, y) in samples(&camera) {
        let column = ((x + 1.0).fract() * 4.0) as usize;
        let row = usize::from(y < 0.0);
        let expected = f32::from(rgb[row * 4 + column][0]) / 255.0 * paper.ambient;
        assert!((picture.rgb[pixel] - expected).abs().max_element() < 1e-7, "{x} {y}");
    }
}
