//! Test scenes, and tests of the limits of the rules.

mod brute_force;
mod closed_form;

use glam::{DVec2, DVec3, Vec3};

use super::Reference;
use crate::quantity::Resolution;
use crate::scene::{
    Animation, Attributes, Camera, Frame, Geometry, Light, Material, MaterialId, Offset, Picture, Projection,
    RenderSpec, Scene, ShadowBits, ShadowRays, Triangle,
};

const OFFSET: f64 = 1.0 / 1024.0;

struct Still(Frame);

impl Animation for Still {
    fn frame(&self, number: u32) -> Frame {
        Frame { number, ..self.0.clone() }
    }
}

/// A scene of one frame, with white lights, white ambient light and a black background.
fn scene(statics: Geometry, dynamic: Geometry, materials: Vec<Material>, lights: &[Vec3], camera: Camera) -> Scene {
    let lights = lights.iter().map(|position| Light { position: *position, color: Vec3::ONE });
    let visible = vec![true; dynamic.len()];
    let frame = Frame { number: 0, camera, lights: lights.collect(), dynamic, visible };
    Scene {
        name: "test".into(),
        statics,
        dynamic_count: frame.dynamic.len(),
        light_count: frame.lights.len(),
        lamps: crate::scene::Lamps::points(),
        frame_count: 1,
        materials,
        textures: Vec::new(),
        background: Vec3::ZERO,
        ambient: Vec3::ONE,
        origin: crate::scene::Origin::default(),
        animation: Box::new(Still(frame)),
    }
}

/// A material that reflects ambient light only: the surface's colour in the picture is `color`.
fn glow(color: Vec3) -> Material {
    Material { ambient: color, diffuse: Vec3::ZERO, ..Material::default() }
}

/// A rectangle in the plane z, counter-clockwise from above.
fn add_rectangle(to: &mut Geometry, low: [f32; 2], high: [f32; 2], z: f32, material: u32) {
    let [a, b, c, d] =
        [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]].map(|[x, y]| Vec3::new(x, y, z));
    let attributes = Attributes { material: MaterialId(material), ..Attributes::default() };
    to.push(Triangle { v: [a, b, c] }, attributes);
    to.push(Triangle { v: [a, c, d] }, attributes);
}

/// Parallel rays along `direction`; the window is 2 units high, and pixel centres lie in the plane `z`.
fn window(z: f64, direction: DVec3) -> Camera {
    Camera {
        eye: DVec3::Z * z,
        right: DVec3::X,
        up: DVec3::Y,
        forward: DVec3::NEG_Z,
        projection: Projection::Parallel { half_height: 1.0, direction },
        jitter: DVec2::ZERO,
    }
}

const SQUARE: Resolution = Resolution { width: 64, height: 64 };

fn render(scene: &Scene, spec: &RenderSpec) -> Picture {
    Reference::new(scene).render(&scene.animation.frame(0), SQUARE, spec, OFFSET)
}

fn spec(depth: u32, shadow_rays: ShadowRays) -> RenderSpec {
    RenderSpec { depth, shadow_rays, offset: Offset::Absolute(OFFSET), min_weight: 1.0 / 256.0 }
}

/// Pixel indices, with the x and y of each sample in the window.
fn samples(camera: &Camera) -> impl Iterator<Item = (usize, f64, f64)> {
    (0..SQUARE.height).flat_map(move |y| (0..SQUARE.width).map(move |x| (x, y))).map(move |(x, y)| {
        let origin = camera.ray(SQUARE, x, y).origin;
        (SQUARE.pixel(x, y).0 as usize, origin.x, origin.y)
    })
}

#[test]
fn segments_are_open_at_both_ends() {
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-1.0; 2], [1.0; 2], 0.0, 0);
    let camera = window(1.0, DVec3::NEG_Z);
    let scene = scene(statics, Geometry::default(), vec![Material::default()], &[], camera);
    let frame = scene.animation.frame(0);
    let reference = Reference::new(&scene);
    let traced = reference.frame(&frame);
    let at = |z: f64| DVec3::new(0.25, 0.5, z);
    for (from, to, blocked) in [
        (1.0, -1.0, true),
        (-1.0, 1.0, true),
        (0.0, 1.0, false),
        (1.0, 0.0, false),
        (2.0, 1.0, false),
        (1.0, 1.0, false),
    ] {
        assert_eq!(traced.occluded(at(from), at(to)), blocked, "{from} {to}");
    }
    assert_eq!(traced.closest(at(0.0), DVec3::Z), None);
    assert_eq!(traced.closest(at(1.0), DVec3::NAN), None);
}

#[test]
fn nothing_to_see() {
    let camera = window(1.0, DVec3::NEG_Z);
    let mut empty = scene(Geometry::default(), Geometry::default(), Vec::new(), &[Vec3::Z], camera);
    empty.background = Vec3::new(0.1, 0.2, 0.3);
    let picture = render(&empty, &spec(4, ShadowRays::Always));
    assert!(picture.rgb.iter().all(|rgb| *rgb == empty.background));
    assert!(picture.hits.iter().all(Option::is_none));
    assert!(picture.shadows.iter().all(|bits| *bits == ShadowBits::default()));

    // Triangles without area are invisible and cast no shadow.
    let mut floor = Geometry::default();
    add_rectangle(&mut floor, [-2.0; 2], [2.0; 2], 0.0, 0);
    let mut with_slivers = floor.clone();
    with_slivers.push(Triangle { v: [Vec3::ZERO, Vec3::Z * 0.5, Vec3::Z * 0.9] }, Attributes::default());
    with_slivers.push(Triangle { v: [Vec3::new(0.1, 0.1, 0.5); 3] }, Attributes::default());
    with_slivers.push(Triangle { v: [Vec3::Z, Vec3::NAN, Vec3::X] }, Attributes::default());
    let of = |statics| scene(statics, Geometry::default(), vec![Material::default()], &[Vec3::Z * 9.0], camera);
    let rays = spec(1, ShadowRays::Always);
    assert_eq!(render(&of(floor), &rays), render(&of(with_slivers), &rays));
}

#[test]
fn threads_change_nothing() {
    let mut statics = Geometry::default();
    for i in 0..40u8 {
        let at = f32::from(i) * 0.05 - 1.0;
        add_rectangle(&mut statics, [at, -at], [at + 0.3, 0.4 - at], at * at, 0);
    }
    let material = Material { specular: Vec3::splat(0.3), transmittance: 0.4, ..Material::default() };
    let camera = window(3.0, DVec3::new(0.2, 0.1, -1.0));
    let lights = [Vec3::new(2.0, 1.0, 5.0), Vec3::new(-3.0, 0.5, 2.0)];
    let scene = scene(statics, Geometry::default(), vec![material], &lights, camera);
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| render(&scene, &spec(4, ShadowRays::ViewerSide)))
    });
    assert!(one.shadows.iter().any(|bits| bits.dark != 0));
    assert_eq!(one, three);
}
