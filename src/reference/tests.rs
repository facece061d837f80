//! The renderer against brute force and against closed forms.

use glam::{DVec2, Vec3};
use proptest::prelude::*;

use super::*;
use crate::scene::{
    Animation, Attributes, Camera, Light, Material, MaterialId, Offset, Projection, ShadowBits, ShadowRays,
};

const OFFSET: f64 = 1.0 / 1024.0;

struct Still(Frame);

impl Animation for Still {
    fn frame(&self, number: u32) -> Frame {
        Frame { number, ..self.0.clone() }
    }
}

/// A scene of one frame whose light and background are black and whose materials send back ambient light alone: a
/// surface's colour in a picture is its material's.
fn scene(statics: Geometry, dynamic: Geometry, materials: Vec<Material>, lights: &[Vec3], camera: Camera) -> Scene {
    let lights = lights.iter().map(|position| Light { position: *position, color: Vec3::ONE });
    let visible = vec![true; dynamic.len()];
    let frame = Frame { number: 0, camera, lights: lights.collect(), dynamic, visible };
    Scene {
        name: "test".into(),
        statics,
        dynamic_count: frame.dynamic.len(),
        light_count: frame.lights.len(),
        frame_count: 1,
        materials,
        textures: Vec::new(),
        background: Vec3::ZERO,
        ambient: Vec3::ONE,
        animation: Box::new(Still(frame)),
    }
}

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

/// Parallel rays along `direction`; the window is 2 high and pixel centres lie in the plane of `z`.
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

/// Pixel indices with the x and y of their sample in the window.
fn samples(camera: &Camera) -> impl Iterator<Item = (usize, f64, f64)> {
    (0..SQUARE.height).flat_map(move |y| (0..SQUARE.width).map(move |x| (x, y))).map(move |(x, y)| {
        let origin = camera.ray(SQUARE, x, y).origin;
        (SQUARE.pixel(x, y).0 as usize, origin.x, origin.y)
    })
}

/// The nearest hit by trying every triangle.
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

/// The shadows of a hit by trying every triangle.
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

/// Corners on a coarse grid, so that many triangles coincide, touch or have no area; or anywhere.
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
        // Straight rays through grid corners and along box sides: 64 pixels on 2 units, shifted by half a pixel.
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

/// A floor seen from below a blocker: its shadow is the blocker as seen from the light, and every pixel is known.
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
    // How far the ray from the start point has come at the blocker's height.
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
    // 0.8 x 0.5, enlarged 1.5 times: 0.9 of 4 units are dark.
    assert_eq!(dark_pixels, 36 * 26);
}

#[test]
fn highlight_of_a_corner_normal() {
    let light = Vec3::new(0.0, 0.0, 3.0);
    let mut statics = Geometry::default();
    add_rectangle(&mut statics, [-2.0; 2], [2.0; 2], 0.0, 0);
    // Tilted by 30 degrees and turned to the wrong side, which must not matter.
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
    // Normals that cancel out give way to the geometric one.
    scene.statics.attributes.iter_mut().for_each(|attributes| attributes.normals = Some([Vec3::ZERO; 3]));
    let flat = render(&scene, &spec(1, ShadowRays::ViewerSide));
    scene.statics.attributes.iter_mut().for_each(|attributes| attributes.normals = None);
    assert_eq!(flat, render(&scene, &spec(1, ShadowRays::ViewerSide)));
}

/// A glowing half-plane at z = 3 seen in a floor of mirror: every pixel is known.
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
    // One unit down to the mirror and three up; the ray starts above the mirror, not aside of it.
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

/// A water surface at z = 0 over a glowing half-plane at z = -2, looked at along `direction` from `z`; gives the colours
/// and the camera. Above, at z = 2, glows another colour.
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
    // Down into the water at an angle with a sine of 0.6: below, the sine is 0.4. Up and out of it from 0.4: 0.6.
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

/// The back of a triangle, lit from its front: asked for only by `Always`, and then its own triangle blocks.
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

    // Triangles without area are not there, neither to be seen nor to throw a shadow.
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
