//! What every culling policy must keep to, whatever it does.

use std::cell::RefCell;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use umbrasim::accel::{AccelSpec, Quality};
use umbrasim::culling::hash_predictor::HashPredictorSpec;
use umbrasim::culling::knowledge::Knowledge;
use umbrasim::culling::last_occluder::LastOccluderSpec;
use umbrasim::culling::occluder_grid::OccluderGridSpec;
use umbrasim::culling::published::rules::{Preset, PublishedSpec};
use umbrasim::culling::symmetric::{Neighbours, SymmetricSpec};
use umbrasim::culling::{Policy, PolicySpec, SceneFacts};
use umbrasim::quantity::Resolution;
use umbrasim::reference::Reference;
use umbrasim::scene::builtin::cases::{CameraPath, Case, Pieces, Recipe};
use umbrasim::scene::builtin::{self};
use umbrasim::scene::{Offset, RenderSpec, Scene, ShadowRays};
use umbrasim::stream::{Checker, Header, Item, RayKind, Structure, Totals};
use umbrasim::tracer::{LaneFrame, PixelOrder, Tracer, TracerSpec};
use umbrasim::validate::{self, Comparison};

/// Every policy with its defaults, and settings that work in another way.
fn policies() -> Vec<(String, PolicySpec)> {
    let named = PolicySpec::all().into_iter().map(|(name, spec)| (name.to_owned(), spec));
    let literal = PublishedSpec { preset: Preset::Literal, ..PublishedSpec::default() };
    let eight = SymmetricSpec { neighbours: Neighbours::Eight, ..SymmetricSpec::default() };
    let others = [("literal", PolicySpec::Published(literal)), ("eight", PolicySpec::Symmetric(eight))];
    let memories = [Knowledge::Latched, Knowledge::Live].into_iter().flat_map(|knowledge| {
        [
            PolicySpec::LastOccluder(LastOccluderSpec { knowledge }),
            PolicySpec::OccluderGrid(OccluderGridSpec { knowledge, ..OccluderGridSpec::default() }),
            PolicySpec::HashPredictor(HashPredictorSpec { knowledge, ..HashPredictorSpec::default() }),
        ]
    });
    let others = others.into_iter().map(|(name, spec)| (name.to_owned(), spec));
    named.chain(others).chain(memories.map(|spec| (format!("{spec:?}"), spec))).collect()
}

/// What a policy did in some frames.
#[derive(Debug, PartialEq)]
struct Trace {
    header: Header,
    items: Vec<Item>,
    wrong: Vec<u64>,
    pictures: Vec<umbrasim::scene::Picture>,
    occlusion_tests: u64,
}

impl Trace {
    fn totals(&self) -> Totals {
        let mut sum = Totals::default();
        for item in &self.items {
            if let Item::End { totals, .. } = item {
                sum += *totals;
            }
        }
        sum
    }
}

struct Setting<'a> {
    scene: &'a Scene,
    frames: u32,
    resolution: Resolution,
    spec: TracerSpec,
    threads: usize,
}

impl<'a> Setting<'a> {
    fn of(scene: &'a Scene, side: u32, render: RenderSpec) -> Self {
        let resolution = Resolution { width: side, height: side };
        Self { scene, frames: 4, resolution, spec: TracerSpec { render, ..TracerSpec::default() }, threads: 2 }
    }

    fn trace(&self, specs: &[(String, PolicySpec)]) -> Vec<Trace> {
        let Self { scene, resolution, .. } = *self;
        let tracer = Tracer::new(scene, &scene.animation.frame(0), resolution, self.spec);
        let facts = SceneFacts::of(scene);
        let mut policies: Vec<Box<dyn Policy>> = specs.iter().map(|(_, spec)| spec.build(facts)).collect();
        let numbers: Vec<_> = (0..self.frames.min(scene.frame_count)).collect();
        let mut traces: Vec<_> = policies
            .iter()
            .zip(specs)
            .map(|(policy, (name, _))| Trace {
                header: Header {
                    scene: scene.name.clone(),
                    frames: numbers.clone(),
                    warmup: Vec::new(),
                    resolution,
                    policy: name.clone(),
                    structure: tracer.accel().structure(),
                    lights: scene.light_count as u32,
                    static_primitives: scene.statics.len() as u32,
                    primitives: scene.primitive_count() as u32,
                    static_nodes: tracer.accel().static_nodes(),
                    static_slots: tracer.accel().static_slots(),
                    static_list_entries: 0,
                    stores: policy.stores(),
                    unjudged_updates: false,
                    input_hash: 0,
                    records: tracer.accel().static_records().into(),
                },
                items: Vec::new(),
                wrong: Vec::new(),
                pictures: Vec::new(),
                occlusion_tests: 0,
            })
            .collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build().expect("a pool");
        for &number in &numbers {
            let frame = scene.animation.frame(number);
            let sink = |lane: usize, item: Item| {
                traces[lane].items.push(item);
                Ok::<_, std::convert::Infallible>(())
            };
            let Ok(lanes) = pool.install(|| tracer.frame(&frame, &mut policies, sink));
            for (trace, lane) in traces.iter_mut().zip(lanes) {
                trace.wrong.push(wrong(&lane));
                trace.pictures.push(lane.picture);
                trace.occlusion_tests += lane.occlusion_tests;
            }
        }
        traces
    }
}

fn wrong(lane: &LaneFrame) -> u64 {
    lane.wrong.iter().map(|wrong| wrong.false_dark + wrong.false_lit).sum()
}

/// The built-in scenes, small, and a recipe's, each with a way of tracing it.
fn scenes() -> Vec<(Scene, RenderSpec)> {
    let built_in = ["Room(detail: 1)", "Street(houses: 1, walkers: 2)", "Thicket(triangles: 2000)"]
        .map(|text| builtin::build(&ron::from_str(text).expect("a scene")));
    let deep = RenderSpec { depth: 3, ..RenderSpec::default() };
    let mut scenes: Vec<_> = built_in.into_iter().map(|scene| (scene, deep)).collect();
    scenes.push((Recipe::default().scene("pieces"), deep));
    scenes
}

#[test]
fn the_same_bytes_whatever_the_number_of_threads() {
    for (scene, render) in scenes() {
        let setting = Setting::of(&scene, 20, render);
        let one = Setting { threads: 1, ..setting }.trace(&policies());
        for threads in [2, 3] {
            let setting = Setting { threads, ..Setting::of(&scene, 20, render) };
            for (one, other) in one.iter().zip(setting.trace(&policies())) {
                assert!(*one == other, "{} {} on {threads} threads", scene.name, other.header.policy);
            }
        }
    }
}

#[test]
fn company_changes_nothing() {
    let (scene, render) = scenes().swap_remove(3);
    let setting = Setting::of(&scene, 20, render);
    let together = setting.trace(&policies());
    for (policy, among) in policies().into_iter().zip(together) {
        let alone = setting.trace(&[policy]).remove(0);
        assert_eq!(alone.totals(), among.totals(), "{}", alone.header.policy);
        assert!(alone.wrong == among.wrong && alone.pictures == among.pictures, "{}", alone.header.policy);
    }
}

#[test]
fn the_order_of_pixels_changes_no_picture() {
    for (scene, render) in scenes() {
        let rows = Setting::of(&scene, 20, render);
        let spec = TracerSpec { order: PixelOrder::Tiles, ..rows.spec };
        let tiles = Setting { spec, ..Setting::of(&scene, 20, render) };
        for (rows, tiles) in rows.trace(&policies()).iter().zip(tiles.trace(&policies())) {
            assert_eq!(rows.wrong, tiles.wrong, "{} {}", scene.name, tiles.header.policy);
            assert!(rows.pictures == tiles.pictures, "{} {}", scene.name, tiles.header.policy);
        }
    }
}

#[test]
fn streams_are_valid_and_say_what_was_counted() {
    for structure in [Structure::Bvh2, Structure::CwBvh] {
        for (scene, render) in scenes() {
            let mut setting = Setting::of(&scene, 20, render);
            setting.spec.accel = AccelSpec { structure, ..AccelSpec::default() };
            for trace in setting.trace(&policies()) {
                let name = &trace.header.policy;
                // It refuses, among others, totals that differ from the records, and an access beyond what the policy
                // says that it keeps.
                let mut checker = Checker::new(&trace.header).expect("a possible header");
                for item in &trace.items {
                    checker.check(item).unwrap_or_else(|fault| panic!("{} {name}: {fault}", scene.name));
                }
                checker.finish().expect("all frames are there");
            }
        }
    }
}

#[test]
fn no_policy_changes_other_rays_than_shadow_rays() {
    for (scene, render) in scenes() {
        let traces = Setting::of(&scene, 20, render).trace(&policies());
        let others = |trace: &Trace| -> Vec<_> {
            let chunks = trace.items.iter().filter_map(|item| match item {
                Item::Rays(chunk) => Some(chunk),
                _ => None,
            });
            let rays = chunks.flat_map(|chunk| chunk.rays().filter(|ray| ray.head.kind != RayKind::Shadow));
            rays.map(|ray| (ray.head, ray.packed_path().to_vec())).collect()
        };
        let off = others(&traces[0]);
        for trace in &traces[1..] {
            assert!(others(trace) == off, "{} {}", scene.name, trace.header.policy);
        }
    }
}

#[test]
fn off_saves_nothing_and_costs_nothing() {
    for (scene, render) in scenes() {
        let traces = Setting::of(&scene, 20, render).trace(&policies());
        let off = traces[0].totals();
        let culled = (off.shadow_rays_skipped, off.shadow_rays_dynamic_only);
        let cost = (off.policy_triangle_tests, off.policy_node_visits, off.policy_reads, off.policy_writes);
        assert_eq!((culled, cost, traces[0].occlusion_tests), ((0, 0), (0, 0, 0, 0), 0));
        assert!(off.shadow_rays > 0, "{}", scene.name);
        for trace in &traces {
            assert_eq!(trace.totals().shadow_rays, off.shadow_rays);
        }
    }
}

#[test]
fn policies_that_cull_do() {
    let (scene, render) = scenes().swap_remove(0);
    let traces = Setting::of(&scene, 32, render).trace(&policies());
    let off = traces[0].totals();
    for ((name, spec), trace) in policies().iter().zip(&traces) {
        let totals = trace.totals();
        match spec {
            PolicySpec::Off => {}
            PolicySpec::Sato => assert_ne!(totals.shadow_node_visits, off.shadow_node_visits),
            _ => assert!(totals.shadow_node_visits < off.shadow_node_visits, "{name}"),
        }
    }
}

/// Wrong decisions of policies that never may make one, secondary hits' included: answers that differ from that of the
/// same ray traced without culling.
fn wrongs_of_exact(setting: &Setting<'_>, traces: &[Trace]) -> Vec<String> {
    let wrong = traces.iter().filter(|trace| trace.wrong.iter().any(|&wrong| wrong > 0));
    wrong.map(|trace| format!("{} {} {:?}", setting.scene.name, trace.header.policy, trace.wrong)).collect()
}

fn traces_of_exact(setting: &Setting<'_>) -> Vec<Trace> {
    let exact: Vec<_> = policies().into_iter().filter(|(_, spec)| spec.is_exact()).collect();
    setting.trace(&exact)
}

/// The pictures of each policy against those of the reference renderer in `f64`; the first is of `Off`, which tells
/// rounding from wrong decisions.
fn against_reference(setting: &Setting<'_>, traces: &[Trace]) -> Vec<Comparison> {
    let scene = setting.scene;
    let offset = Tracer::new(scene, &scene.animation.frame(0), setting.resolution, setting.spec).offset();
    let reference = Reference::new(scene);
    let mut sums = vec![Comparison::default(); traces.len()];
    for (at, &number) in traces[0].header.frames.iter().enumerate() {
        let frame = scene.animation.frame(number);
        let truth = reference.render(&frame, setting.resolution, &setting.spec.render, offset);
        for (sum, trace) in sums.iter_mut().zip(traces) {
            let plain = &traces[0].pictures[at];
            let compared = validate::compare(&truth, plain, &trace.pictures[at], scene.light_count);
            *sum += &compared.expect("the pictures are of the same rays").0;
        }
    }
    sums
}

#[test]
fn exact_policies_are_never_wrong_on_scenes_and_cases() {
    let mut wrong = Vec::new();
    for structure in [Structure::Bvh2, Structure::CwBvh] {
        let accel = AccelSpec { structure, ..AccelSpec::default() };
        for (scene, render) in scenes() {
            let mut setting = Setting::of(&scene, 48, render);
            setting.spec.accel = accel;
            wrong.extend(wrongs_of_exact(&setting, &traces_of_exact(&setting)));
        }
        for case in Case::all() {
            let scene = case.scene();
            let mut setting = Setting { frames: 8, ..Setting::of(&scene, case.resolution().width, case.render()) };
            setting.spec.accel = accel;
            wrong.extend(wrongs_of_exact(&setting, &traces_of_exact(&setting)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn recipes() -> impl Strategy<Value = Recipe> {
    let pieces =
        prop_oneof![Just(Pieces::Any), Just(Pieces::Slivers), Just(Pieces::Degenerate), Just(Pieces::Coplanar)];
    let camera = prop_oneof![Just(CameraPath::Jitter), Just(CameraPath::Pan), Just(CameraPath::Jump)];
    let centre = prop_oneof![Just([0.0; 3]), Just([1e4, -2e4, 3e4]), Just([1e6, 0.0, -1e6])];
    let numbers = (0u32..5, 0u32..40, 0u32..8, 0u32..4, prop_oneof![3 => Just(0), 1 => 1u32..4]);
    (any::<u64>(), centre, numbers, pieces, any::<bool>(), camera).prop_map(
        |(seed, centre, (ground, count, moving, lights, area), pieces, lights_move, camera)| Recipe {
            seed,
            centre,
            ground,
            count,
            pieces,
            moving,
            lights,
            lights_move,
            area,
            camera,
        },
    )
}

/// How a random scene is traced.
fn ways() -> impl Strategy<Value = (u32, TracerSpec)> {
    let offset = prop_oneof![Just(Offset::Absolute(1e-4)), Just(Offset::Relative(1e-5)), Just(Offset::Relative(1e-8))];
    let shadow_rays = prop_oneof![Just(ShadowRays::ViewerSide), Just(ShadowRays::Always)];
    let structure = prop_oneof![Just(Structure::Bvh2), Just(Structure::CwBvh)];
    let statics = prop_oneof![Just(Quality::Fast), Just(Quality::Best)];
    (4u32..20, offset, shadow_rays, structure, statics).prop_map(|(side, offset, shadow_rays, structure, statics)| {
        let render = RenderSpec { depth: 2, shadow_rays, offset, ..RenderSpec::default() };
        let accel = AccelSpec { structure, statics, ..AccelSpec::default() };
        (side, TracerSpec { render, accel, ..TracerSpec::default() })
    })
}

/// Decisions that were compared with the reference renderer's, and those that differ by rounding.
#[derive(Clone, Copy, Default)]
struct Rounding {
    scenes: u64,
    asked: u64,
    differ: u64,
}

/// 200 scenes, always the same; with the environment variable `UMBRASIM_LONG`, 10,000, always others.
#[test]
fn exact_policies_are_never_wrong_on_random_scenes() {
    let long = std::env::var_os("UMBRASIM_LONG").is_some();
    let config = Config { cases: if long { 10_000 } else { 200 }, failure_persistence: None, ..Config::default() };
    let mut runner = if long {
        TestRunner::new(config)
    } else {
        TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
    };
    // Scenes around the origin with a usual offset, and those that `f32` can hardly hold.
    let rounding = RefCell::new([Rounding::default(); 2]);
    let result = runner.run(&(recipes(), ways()), |(recipe, (side, spec))| {
        let scene = recipe.scene("random");
        let setting = Setting { spec, ..Setting::of(&scene, side, spec.render) };
        let traces = traces_of_exact(&setting);
        let mut wrong = wrongs_of_exact(&setting, &traces);
        let compared = against_reference(&setting, &traces);
        for (trace, comparison) in traces.iter().zip(&compared) {
            let all = comparison.all_lights();
            if all.false_dark + all.false_lit > 0 {
                wrong.push(format!("{}: {all:?} against the reference renderer", trace.header.policy));
            }
        }
        let usual = recipe.centre == [0.0; 3] && spec.render.offset != Offset::Relative(1e-8);
        let counts = &mut rounding.borrow_mut()[usize::from(!usual)];
        let off = compared[0].all_lights();
        counts.scenes += 1;
        counts.asked += off.asked;
        counts.differ += off.numeric_differences;
        if wrong.is_empty() { Ok(()) } else { Err(TestCaseError::fail(wrong.join("\n"))) }
    });
    result.unwrap_or_else(|error| panic!("{error}"));
    for (what, Rounding { scenes, asked, differ }) in
        ["around the origin", "hard for f32"].into_iter().zip(rounding.into_inner())
    {
        println!(
            "{scenes} scenes {what}: {asked} decisions, {differ} differ from f64 by rounding, without culling too"
        );
        assert!(asked > 1000 && differ < asked, "{what}");
    }
}
