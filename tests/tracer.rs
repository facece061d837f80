//! The tracer against the reference renderer, against itself on other threads and in other orders, and on one
//! acceleration structure against the other.

mod common;

use std::path::Path;

use common::{ROOT, shared};
use umbrasim::accel::AccelSpec;
use umbrasim::culling::PolicySpec;
use umbrasim::experiment::{Experiment, Overrides};
use umbrasim::quantity::Resolution;
use umbrasim::reference::Reference;
use umbrasim::stream::{StreamWriter, Structure, Totals};
use umbrasim::tracer::{LaneFrame, PixelOrder, Tracer, TracerSpec};
use umbrasim::validate::{self, Comparison};

/// The experiment in `configs/experiments`, with another scene of `configs/scenes` if it is named, in pictures of
/// `side` pixels a side.
fn experiment(name: &str, scene: Option<&str>, side: u32) -> Experiment {
    let file = Path::new(ROOT).join("configs/experiments").join(name);
    let resolution = Some(Resolution { width: side, height: side });
    let mut experiment = Experiment::load(&file, Overrides { resolution, ..Overrides::default() }).unwrap();
    if let Some(scene) = scene {
        let folder = Path::new(ROOT).join("configs/scenes");
        let spec: umbrasim::scene::spec::SceneSpec = umbrasim::ron_file::read(&folder.join(scene)).unwrap();
        experiment.scene = spec.load(&folder).unwrap();
    }
    experiment
}

/// What one tracing of some frames gave.
struct Traced {
    /// By frame, then policy.
    lanes: Vec<Vec<LaneFrame>>,
    /// The streams' bytes, by policy.
    streams: Vec<Vec<u8>>,
    offset: f64,
}

impl Traced {
    /// By policy, then frame.
    fn totals(&self) -> Vec<Vec<Totals>> {
        let of = |policy: usize| self.lanes.iter().map(|lanes| lanes[policy].totals).collect();
        (0..self.streams.len()).map(of).collect()
    }
}

/// Traces `frames` for the experiment's policies.
fn trace(experiment: &Experiment, frames: &[u32], spec: TracerSpec) -> Traced {
    let scene = &experiment.scene;
    let tracer = Tracer::new(scene, &scene.animation.frame(frames[0]), experiment.spec.resolution, spec);
    let mut policies = experiment.policies();
    let names: Vec<&str> = experiment.policy_names().collect();
    let mut writers: Vec<_> = names
        .iter()
        .zip(&policies)
        .map(|(name, policy)| {
            let header = tracer.header(name, policy.as_ref(), frames.to_vec(), "");
            StreamWriter::new(Vec::new(), Path::new("memory"), &header).unwrap()
        })
        .collect();
    let of = |&number: &u32| {
        let sink = |policy: usize, item| writers[policy].write(&item);
        tracer.frame(&scene.animation.frame(number), &mut policies, sink).unwrap()
    };
    let lanes = frames.iter().map(of).collect();
    let streams = writers.into_iter().map(|writer| writer.complete().unwrap()).collect();
    Traced { lanes, streams, offset: tracer.offset() }
}

/// Compares the pictures without culling with the reference renderer's, and asserts that they agree but for rounding:
/// of the scenes here at most 0.08 % of the primary hits differ, where two triangles meet, and 0.002 % of the
/// decisions; the least PSNR is 56 dB, of textured scenes.
fn against_reference(experiment: &Experiment, frames: &[u32]) {
    let traced = trace(experiment, frames, experiment.spec.tracer);
    let reference = Reference::new(&experiment.scene);
    let off = experiment.off();
    let mut sum = Comparison::default();
    let mut inner = 0;
    for (&number, lanes) in frames.iter().zip(&traced.lanes) {
        let frame = experiment.scene.animation.frame(number);
        let resolution = experiment.spec.resolution;
        let truth = reference.render(&frame, resolution, &experiment.spec.tracer.render, traced.offset);
        let ours = &lanes[off].picture;
        let (comparison, _) = validate::compare(&truth, ours, ours, experiment.scene.light_count).unwrap();
        sum += &comparison;
        // A hit that differs lies at an edge: the reference's primitive is also seen next to it, or another one is.
        let at = |x: u32, y: u32| truth.hits[resolution.pixel(x, y).0 as usize];
        for y in 1..resolution.height - 1 {
            for x in 1..resolution.width - 1 {
                let here = at(x, y);
                let around = [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)];
                let differs = ours.hits[resolution.pixel(x, y).0 as usize] != here;
                inner += u64::from(differs && around.iter().all(|other| *other == here));
            }
        }
    }
    let all = sum.all_lights();
    let psnr = sum.against_reference.psnr().unwrap_or(f64::INFINITY);
    println!(
        "{}: {} of {} primary hits and {} of {} decisions differ, PSNR {psnr:.1} dB",
        experiment.scene.name, sum.hit_differences, sum.pixels, all.numeric_differences, all.asked
    );
    assert!(all.asked > sum.pixels / 2, "too few decisions to say anything: {all:?}");
    assert!(sum.hit_differences * 1000 <= sum.pixels, "{sum:?}");
    assert!(all.numeric_differences * 10_000 <= all.asked, "{all:?}");
    assert_eq!(inner, 0, "primary hits differ away from edges");
    assert!(psnr > 50.0, "{psnr}");
}

#[test]
fn built_in_scenes_agree_with_the_reference_renderer() {
    for scene in ["room.ron", "street.ron", "thicket.ron"] {
        against_reference(&experiment("quickstart.ron", Some(scene), 96), &[0, 40]);
    }
}

#[test]
fn secondary_rays_agree_with_the_reference_renderer() {
    let mut experiment = experiment("quickstart.ron", None, 64);
    experiment.spec.tracer.render.depth = 5;
    against_reference(&experiment, &[0]);
}

#[test]
fn real_scenes_agree_with_the_reference_renderer() {
    for (config, needs) in
        [("bart_kitchen.ron", "bart/kitchen/aff/kitchen.aff"), ("bart_robot.ron", "bart/robot/aff/Robot.aff")]
    {
        if shared(needs).is_some() {
            against_reference(&experiment(config, None, 96), &[0, 320]);
        }
    }
}

#[test]
fn threads_change_nothing() {
    let mut experiment = experiment("quickstart.ron", None, 72);
    experiment.spec.tracer.render.depth = 3;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trace(&experiment, &[0, 1, 2, 3], experiment.spec.tracer))
    };
    let one = on(1);
    assert!(one.streams.iter().all(|stream| stream.len() > 100_000));
    assert_ne!(one.totals()[0], one.totals()[1], "the policies do the same: nothing is tested");
    for threads in [2, 3] {
        let other = on(threads);
        assert_eq!(one.totals(), other.totals(), "{threads} threads");
        assert!(one.streams == other.streams, "{threads} threads");
        for (one, other) in one.lanes.iter().flatten().zip(other.lanes.iter().flatten()) {
            assert!(one.picture == other.picture, "{threads} threads");
        }
    }
}

#[test]
fn the_order_of_pixels_changes_no_count() {
    let experiment = experiment("quickstart.ron", None, 72);
    let ordered = |order| trace(&experiment, &[0, 1, 2, 3], TracerSpec { order, ..experiment.spec.tracer });
    let [rows, tiles] = [PixelOrder::Scanline, PixelOrder::Tiles].map(ordered);
    assert_eq!(rows.totals(), tiles.totals());
    assert!(rows.streams[0] != tiles.streams[0], "the order is the same: nothing is tested");
    for (rows, tiles) in rows.lanes.iter().flatten().zip(tiles.lanes.iter().flatten()) {
        assert!(rows.picture == tiles.picture);
    }
}

#[test]
fn both_structures_find_the_same() {
    for scene in ["room.ron", "street.ron", "thicket.ron"] {
        let mut experiment = experiment("quickstart.ron", Some(scene), 96);
        experiment.spec.policies = [("Off", PolicySpec::Off)].into_iter().collect();
        let structured = |structure| {
            let accel = AccelSpec { structure, ..AccelSpec::default() };
            trace(&experiment, &[0, 40], TracerSpec { accel, ..experiment.spec.tracer })
        };
        let [binary, wide] = [Structure::Bvh2, Structure::CwBvh].map(structured);
        let (mut hits, mut shadows) = (0, 0);
        for (binary, wide) in binary.lanes.iter().flatten().zip(wide.lanes.iter().flatten()) {
            let (binary, wide) = (&binary.picture, &wide.picture);
            hits += binary.hits.iter().zip(&wide.hits).filter(|(one, other)| one != other).count();
            shadows += binary.shadows.iter().zip(&wide.shadows).filter(|(one, other)| one != other).count();
        }
        println!("{scene}: {hits} hits and {shadows} shadows differ");
        assert_eq!((hits, shadows), (0, 0), "{scene}");
        assert_ne!(binary.totals(), wide.totals(), "the structures are the same: nothing is tested");
    }
}
