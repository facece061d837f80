//! Tests for every structure: it must find the same as a test of every triangle, and record its steps.

use std::path::Path as FilePath;

use glam::{DVec3, Vec3};
use proptest::prelude::*;

use super::*;
use crate::culling::{Policy, PolicySpec, SceneFacts};
use crate::quantity::{ListId, NodeId, PrimitiveId, Resolution};
use crate::scene::{self, Animation, Attributes, Camera, Frame, Geometry, Light, Scene, Triangle};
use crate::stream::{self, Step, Structure, Totals};
use crate::tracer::{Tracer, TracerSpec};

struct Still(Frame);

impl Animation for Still {
    fn frame(&self, _: u32) -> Frame {
        self.0.clone()
    }
}

fn specs() -> Vec<AccelSpec> {
    let bvh = AccelSpec::default();
    let kd = AccelSpec { structure: Structure::KdTree, ..bvh };
    vec![
        bvh,
        AccelSpec { statics: Quality::Fast, dynamic: Quality::Best, ..bvh },
        AccelSpec { structure: Structure::CwBvh, ..bvh },
        kd,
        AccelSpec { statics: Quality::Medium, dynamic: Quality::Best, kd_layout: KdLayout::DepthFirst, ..kd },
        AccelSpec { statics: Quality::Fast, dynamic: Quality::Medium, ..kd },
    ]
}

fn geometry(triangles: &[Triangle]) -> Geometry {
    Geometry { triangles: triangles.to_vec(), attributes: vec![Attributes::default(); triangles.len()] }
}

/// A soup of triangles. The last ones can move; one in four of the movable triangles is invisible.
struct Soup {
    scene: Scene,
    frame: Frame,
}

impl Soup {
    fn new(triangles: &[Triangle], moving: usize) -> Self {
        let (statics, dynamic) = triangles.split_at(triangles.len() - moving.min(triangles.len()));
        let frame = Frame {
            number: 0,
            camera: Camera::perspective(DVec3::ZERO, DVec3::X, DVec3::Z, 1.0),
            lights: Vec::new(),
            dynamic: geometry(dynamic),
            visible: (0..dynamic.len()).map(|index| index % 4 != 3).collect(),
        };
        let scene = Scene {
            name: "soup".into(),
            statics: geometry(statics),
            dynamic_count: dynamic.len(),
            light_count: 0,
            lamps: scene::Lamps::points(),
            frame_count: 1,
            materials: Vec::new(),
            textures: Vec::new(),
            background: Vec3::ZERO,
            ambient: Vec3::ZERO,
            origin: crate::scene::Origin::default(),
            animation: Box::new(Still(frame.clone())),
        };
        Self { scene, frame }
    }

    /// Records of all visible triangles.
    fn records(&self) -> Vec<Record> {
        let there = |&primitive: &PrimitiveId| {
            let moving = primitive.0.checked_sub(self.scene.statics.len() as u32);
            moving.is_none_or(|index| self.frame.visible[index as usize])
        };
        let primitives = (0..self.scene.primitive_count() as u32).map(PrimitiveId).filter(there);
        primitives.map(|primitive| Record::new(self.scene.triangle(&self.frame, primitive), primitive)).collect()
    }

    /// Compares every structure with the test of all triangles, for each of `rays`.
    fn check(&self, rays: &[Ray]) -> Result<(), TestCaseError> {
        let records = self.records();
        for spec in specs() {
            let accel = Accel::new(&self.scene, spec);
            let world = accel.frame(&self.scene, &self.frame);
            for ray in rays {
                let hits = records.iter().filter_map(|record| {
                    let hit = record.test(ray).1.filter(|hit| hit.t <= ray.reach)?;
                    Some(Hit { primitive: record.primitive, t: hit.t, barycentric: hit.barycentric })
                });
                let nearest = hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.primitive.cmp(&b.primitive)));
                let mut trail = Trail::default();
                prop_assert_eq!(world.closest(ray, &mut trail), nearest, "{:?} {:?}", spec, ray);
                check_trail(&trail, &accel, &world)?;

                let blockers: Vec<_> =
                    records.iter().filter(|record| record.blocks(ray).1).map(|record| record.primitive).collect();
                for scope in [Scope::All, Scope::Dynamic] {
                    let mut trail = Trail::default();
                    let found = world.occluded(ray, scope, &mut trail);
                    let counts = |&blocker: &PrimitiveId| scope == Scope::All || self.scene.is_dynamic(blocker);
                    let expected: Vec<_> = blockers.iter().copied().filter(counts).collect();
                    prop_assert_eq!(found.is_some(), !expected.is_empty(), "{:?} {:?} {:?}", spec, scope, ray);
                    if let Some(found) = found {
                        prop_assert!(expected.contains(&found));
                        let static_first = scope == Scope::Dynamic
                            || !self.scene.is_dynamic(found)
                            || blockers.iter().all(|&blocker| self.scene.is_dynamic(blocker));
                        prop_assert!(static_first, "{:?} {:?}", spec, ray);
                    }
                    if scope == Scope::All || self.scene.dynamic_count > 0 {
                        check_trail(&trail, &accel, &world)?;
                    } else {
                        prop_assert!(trail.steps.is_empty());
                    }
                }
            }
            for record in &records {
                let ray = rays[0];
                let expected = record.test(&ray).1.map(|hit| hit.t);
                prop_assert_eq!(world.test(&ray, record.primitive, &mut Silent), expected);
            }
        }
        Ok(())
    }
}

/// Checks that the steps match the counts, stay in bounds, and have an order that the hardware could take.
fn check_trail(trail: &Trail, accel: &Accel, world: &World<'_>) -> Result<(), TestCaseError> {
    let info = world.info();
    let steps: Vec<_> = trail.steps.iter().map(|&word| Step::unpack(word).unwrap()).collect();
    let (mut nodes, mut lists, mut triangles) = (0, 0, 0);
    prop_assert_eq!(steps.first(), Some(&Step::Node(NodeId(0))));
    for (index, step) in steps.iter().enumerate() {
        match *step {
            Step::Node(NodeId(node)) => {
                nodes += 1;
                prop_assert!(node < accel.static_nodes() + info.dynamic_nodes);
            }
            Step::List(ListId(entry)) => {
                lists += 1;
                prop_assert!(entry < accel.static_list_entries() + info.dynamic_list_entries);
                let tested = matches!(steps.get(index + 1), Some(Step::Triangle { .. }));
                prop_assert!(tested);
            }
            Step::Triangle { slot, .. } => {
                triangles += 1;
                prop_assert!(slot.0 < accel.static_slots() + info.dynamic_slots);
                let listed = matches!(steps[index - 1], Step::List(_));
                prop_assert_eq!(listed, accel.structure() == Structure::KdTree);
            }
            other => prop_assert!(false, "{other:?} in a path"),
        }
    }
    prop_assert_eq!((nodes, lists, triangles), (trail.nodes, trail.lists, trail.triangles));
    Ok(())
}

/// Points with integer coordinates. Triangles are often degenerate, equal, coplanar, or in a plane across an axis, and
/// rays often meet corners and edges; still the triangle test is exact.
fn lattice_point(half: i32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-half..=half).prop_map(|[x, y, z]| Vec3::new(x as f32, y as f32, z as f32))
}

fn lattice_triangle() -> impl Strategy<Value = Triangle> {
    let any = prop::array::uniform3(lattice_point(6)).prop_map(|v| Triangle { v });
    let flat = (prop::array::uniform3(lattice_point(6)), 0..3usize).prop_map(|(mut v, axis)| {
        let at = v[0][axis];
        v.iter_mut().for_each(|corner| corner[axis] = at);
        Triangle { v }
    });
    prop_oneof![any, flat]
}

fn lattice_ray() -> impl Strategy<Value = Ray> {
    let direction = prop_oneof![
        lattice_point(8),
        (0..3usize, prop::bool::ANY).prop_map(|(axis, back)| Vec3::AXES[axis] * if back { -3.0 } else { 1.0 })
    ];
    let direction = direction.prop_filter("a ray goes somewhere", |&direction| direction != Vec3::ZERO);
    let reach = prop_oneof![Just(f32::INFINITY), Just(1.0), Just(2.0)];
    (lattice_point(10), direction, reach).prop_map(|(origin, direction, reach)| Ray::new(origin, direction, reach))
}

/// Moves and scales a lattice point. Every coordinate stays exact in `f32`: a scale is a power of two, and a place has
/// integer coordinates.
fn put(point: Vec3, place: Vec3, scale: f32) -> Vec3 {
    (point + place) * scale
}

fn random_point() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1.0f32..1.0).prop_map(Vec3::from_array)
}

/// The distance at which the ray clearly hits the triangle, or `Some(None)` if it clearly misses; `None` if rounding
/// could decide.
fn clear_distance(triangle: &Triangle, ray: &Ray) -> Option<Option<f64>> {
    let [a, b, c] = triangle.v.map(Vec3::as_dvec3);
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let normal = e1.cross(e2);
    let facing = -direction.dot(normal);
    // Bound on the relative error of the terms divided by `facing`: about a thousand roundings.
    let margin = 1e-4 * direction.length() * e1.length() * e2.length() / facing.abs();
    let moment = (origin - a).cross(direction);
    let (u, v) = (e2.dot(moment) / facing, -e1.dot(moment) / facing);
    let t = (origin - a).dot(normal) / facing;
    let inside = u.min(v).min(1.0 - u - v);
    if inside < -margin || t < -margin {
        return Some(None);
    }
    let reach = f64::from(ray.reach);
    if !(inside > margin && t > margin && ((t - reach).abs() > margin || reach.is_infinite())) {
        return None;
    }
    Some((t < reach).then_some(t))
}

/// Whether rounding cannot change what the ray hits.
fn is_clear(triangles: &[Triangle], ray: &Ray) -> bool {
    let Some(hits) = triangles.iter().map(|triangle| clear_distance(triangle, ray)).collect::<Option<Vec<_>>>() else {
        return false;
    };
    let mut hits: Vec<_> = hits.into_iter().flatten().collect();
    hits.sort_by(f64::total_cmp);
    hits.windows(2).all(|pair| pair[1] - pair[0] > 1e-4 * pair[1])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn lattice_soups_are_traced_as_by_brute_force(
        triangles in prop::collection::vec(lattice_triangle(), 0..60),
        moving in 0..40usize,
        rays in prop::collection::vec(lattice_ray(), 1..40),
        place in prop_oneof![Just(Vec3::ZERO), Just(Vec3::new(4096.0, -65536.0, 1000.0))],
        exponent in prop_oneof![Just(0), Just(-20), Just(12)],
    ) {
        let scale = 2.0f32.powi(exponent);
        let put = |point| put(point, place, scale);
        let triangles: Vec<_> = triangles.iter().map(|triangle| Triangle { v: triangle.v.map(put) }).collect();
        let rays: Vec<_> =
            rays.iter().map(|ray| Ray::new(put(ray.origin), ray.direction * scale, ray.reach)).collect();
        Soup::new(&triangles, moving).check(&rays)?;
    }

    #[test]
    fn random_soups_are_traced_as_by_brute_force(
        corners in prop::collection::vec((random_point(), random_point(), random_point()), 1..300),
        // Triangles from the size of the scene down to a thousandth of it.
        size in prop_oneof![Just(1.0f32), Just(0.1), Just(0.001)],
        moving in 0..200usize,
        rays in prop::collection::vec((random_point(), random_point()), 40),
        place in prop_oneof![Just(Vec3::ZERO), Just(Vec3::new(300.0, -2000.0, 50.0))],
    ) {
        let triangles: Vec<_> = corners
            .iter()
            .map(|&(middle, a, b)| Triangle { v: [Vec3::ZERO, a, b].map(|corner| middle + corner * size + place) })
            .collect();
        let soup = Soup::new(&triangles, moving);
        // Half of the rays are aimed at a triangle.
        let rays: Vec<_> = rays
            .iter()
            .enumerate()
            .map(|(index, &(from, to))| {
                let aim = triangles[index % triangles.len()].v;
                let target = if index % 2 == 0 { to + place } else { (aim[0] + aim[1] + aim[2]) / 3.0 };
                let origin = from * 2.0 + place;
                Ray::new(origin, target - origin, if index % 3 == 0 { 1.5 } else { f32::INFINITY })
            })
            .filter(|ray| is_clear(&triangles, ray))
            .collect();
        prop_assume!(!rays.is_empty());
        soup.check(&rays)?;
    }
}

#[test]
fn an_empty_scene_is_missed() {
    let nothing = Soup::new(&[], 0);
    nothing.check(&[Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY)]).unwrap();
}

#[test]
fn a_dynamic_ray_never_enters_the_static_tree() {
    let wall = |x: f32| Triangle { v: [Vec3::new(x, -9.0, -9.0), Vec3::new(x, 9.0, -9.0), Vec3::new(x, 0.0, 9.0)] };
    let walls: Vec<_> = (1..40).map(|x| wall(x as f32)).collect();
    let soup = Soup::new(&walls, 10);
    for spec in specs() {
        let accel = Accel::new(&soup.scene, spec);
        let world = accel.frame(&soup.scene, &soup.frame);
        let mut trail = Trail::default();
        world.occluded(&Ray::segment(Vec3::ZERO, Vec3::X * 50.0), Scope::Dynamic, &mut trail);
        let mut nodes = trail.steps.iter().filter_map(|&word| match Step::unpack(word) {
            Some(Step::Node(node)) => Some(node.0),
            _ => None,
        });
        assert_eq!(nodes.next(), Some(0), "{spec:?}");
        assert!(nodes.all(|node| node >= accel.static_nodes()), "{spec:?}");
    }
}

fn bart(file: &str) -> Option<Scene> {
    let path = FilePath::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/scenes/bart")).join(file);
    if path.exists() {
        Some(scene::aff::load(&path).unwrap())
    } else {
        println!("skipped: {} is absent", path.display());
        None
    }
}

/// Checks that all structures agree on the hits of all primary rays of a frame, and on which shadow rays from there
/// are blocked (by any triangle, or by dynamic ones).
fn check_frame(scene: &Scene, number: u32) {
    let frame = scene.animation.frame(number);
    let resolution = Resolution { width: 512, height: 512 };
    let pixels = (0..resolution.height).flat_map(|y| (0..resolution.width).map(move |x| (x, y)));
    let rays: Vec<_> = pixels
        .map(|(x, y)| {
            let ray = frame.camera.ray(resolution, x, y);
            Ray::new(ray.origin.as_vec3(), ray.direction.as_vec3(), f32::INFINITY)
        })
        .collect();
    let mut first = None;
    for spec in specs() {
        let accel = Accel::new(scene, spec);
        let world = accel.frame(scene, &frame);
        let hits: Vec<_> = rays.iter().map(|ray| world.closest(ray, &mut Silent)).collect();
        let ids: Vec<_> = hits.iter().map(|hit| hit.map(|hit| hit.primitive)).collect();
        // Shadow rays start slightly before the surface.
        let points = rays
            .iter()
            .zip(&hits)
            .filter_map(|(ray, hit)| Some(ray.origin + ray.direction * (hit.as_ref()?.t * 0.9999)));
        let shadows: Vec<_> = points
            .flat_map(|point| frame.lights.iter().map(move |light| Ray::segment(point, light.position)))
            .flat_map(|ray| {
                [Scope::All, Scope::Dynamic].map(|scope| world.occluded(&ray, scope, &mut Silent).is_some())
            })
            .collect();
        assert!(shadows.contains(&true) && shadows.contains(&false));
        match &first {
            None => first = Some((ids, shadows)),
            Some(first) => assert!(*first == (ids, shadows), "{spec:?} differs"),
        }
    }
}

#[test]
fn all_structures_see_the_same_kitchen() {
    let Some(scene) = bart("kitchen/aff/kitchen.aff") else { return };
    check_frame(&scene, 16);
}

#[test]
fn all_structures_see_the_same_robot() {
    let Some(scene) = bart("robot/aff/Robot.aff") else { return };
    check_frame(&scene, 432);
}

/// A floor, two smaller walls above it, and two lights.
fn lit_soup() -> Soup {
    let wall = |z: f32, half: f32| {
        let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, z);
        [
            Triangle { v: [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)] },
            Triangle { v: [corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)] },
        ]
    };
    let mut soup = Soup::new(&[wall(0.0, 9.0), wall(2.0, 1.0), wall(3.0, 2.0)].concat(), 2);
    let light = |x: f32| Light { position: Vec3::new(x, 1.0, 8.0), color: Vec3::ONE };
    soup.frame.lights = vec![light(-3.0), light(4.0)];
    soup.frame.camera = Camera::perspective(DVec3::new(0.0, -8.0, 8.0), DVec3::new(0.0, 1.0, -1.0), DVec3::Z, 1.0);
    soup.scene.light_count = 2;
    soup.scene.materials = vec![scene::Material { specular: Vec3::splat(0.3), ..Default::default() }];
    soup
}

#[test]
fn the_records_say_what_the_tracer_counted() {
    let soup = lit_soup();
    let facts = SceneFacts {
        statics: soup.scene.statics.len() as u32,
        primitives: 6,
        lights: 2,
        lamps: scene::Lamps::points(),
    };
    for accel in specs() {
        let mut spec = TracerSpec { accel, ..TracerSpec::default() };
        spec.render.depth = 3;
        let tracer = Tracer::new(&soup.scene, &soup.frame, Resolution { width: 40, height: 30 }, spec);
        let mut policies: Vec<Box<dyn Policy>> =
            vec![PolicySpec::Off.build(facts), PolicySpec::Published(Default::default()).build(facts)];
        let mut counted = [Totals::default(); 2];
        let sink = |lane: usize, item: stream::Item| {
            match item {
                stream::Item::Frame(_) => {}
                stream::Item::Rays(chunk) => chunk.rays().for_each(|ray| counted[lane].count(&ray)),
                stream::Item::End { policy, totals } => {
                    counted[lane].count_policy(policy.iter().filter_map(|&word| Step::unpack(word)));
                    assert_eq!(totals, counted[lane], "{accel:?}");
                }
            }
            Ok::<_, ()>(())
        };
        tracer.frame(&soup.frame, &mut policies, sink).unwrap();
        let [off, published] = counted;
        let lists = accel.structure == Structure::KdTree;
        assert_eq!(off.list_reads, if lists { off.triangle_tests + off.shadow_triangle_tests } else { 0 });
        assert!(off.secondary_rays > 0 && off.shadow_triangle_tests > 0 && published.policy_reads > 0);
    }
}

/// 20,000 equal triangles, with 40 others on both sides of them: a build in quadratic time takes a minute.
#[test]
fn many_equal_triangles_are_built_over_in_time() {
    let triangle =
        |at: f32| Triangle { v: [Vec3::new(at, 0.0, 1.0), Vec3::new(at + 1.0, 0.0, 1.0), Vec3::new(at, 1.0, 2.0)] };
    let others = (0..40).map(|at| triangle(at as f32 - 20.0));
    let triangles: Vec<_> = others.chain(std::iter::repeat_n(triangle(0.0), 20_000)).collect();
    let soup = Soup::new(&triangles, 10_000);
    let begin = std::time::Instant::now();
    let ray = |x: f32| Ray::new(Vec3::new(x, 0.25, 0.0), Vec3::Z, f32::INFINITY);
    soup.check(&[ray(0.25), ray(7.25), ray(50.0)]).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    assert!(seconds < 20.0, "{seconds} s");
}
