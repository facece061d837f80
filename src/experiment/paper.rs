//! The table of GI09 under every reading of its text: published figures beside measured ones.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::files::named;
use super::frames::FrameRange;
use super::load::ExperimentError;
use super::load::{check_boxes, read_scene};
use super::progress;
use super::run::frame_result;
use crate::culling::{PolicySpec, SceneFacts};
use crate::named::Named;
use crate::quantity::Resolution;
use crate::ranged::Within;
use crate::report::Grid;
use crate::report::format::{ABSENT, exact, or_absent, percent};
use crate::report::run::{FrameResult, PolicySummary, Saved};
use crate::ron_file::{self, ConfigError, Kind};
use crate::scene::{Scene, ShadowRays};
use crate::stream::Structure;
use crate::tracer::{Tracer, TracerSpec};

/// Compares readings of the paper's text with its table. Every combination of the listed values is traced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperSpec {
    /// The scenes, each with the paper's figures.
    pub scenes: Vec<PaperScene>,
    /// Size of the pictures.
    pub resolution: Resolution,
    /// The frames to trace.
    pub frames: Vec<FrameRange>,
    /// Acceleration structures to try.
    pub structures: Vec<Structure>,
    /// Maximum ray depths to try; depth 1 is the primary ray.
    pub depths: Vec<Within<1, 32>>,
    /// Values to try for the rule which lights get a shadow ray.
    pub shadow_rays: Vec<ShadowRays>,
    /// Policies, each compared with no culling.
    pub policies: Named<PolicySpec>,
}

/// A scene of the paper's table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaperScene {
    /// The scene's file.
    pub scene: PathBuf,
    /// The paper's figures.
    pub published: Figures,
}

/// The figures of a scene, published or measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Figures {
    /// Share of the node visits of shadow rays that culling saves.
    pub traversal_saved: MeanMax,
    /// Share of the triangle tests of shadow rays that culling saves.
    pub intersection_saved: MeanMax,
    /// Occlusion tests per pixel.
    pub occlusion_tests_per_pixel: f64,
}

/// Mean and maximum over frames of a share of saved work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeanMax {
    /// Mean over the frames.
    pub mean: f64,
    /// The share of the best frame.
    pub max: f64,
}

impl Figures {
    /// Root of the mean squared difference of the four shares saved.
    pub fn distance(&self, other: &Self) -> f64 {
        let differences = [
            self.traversal_saved.mean - other.traversal_saved.mean,
            self.traversal_saved.max - other.traversal_saved.max,
            self.intersection_saved.mean - other.intersection_saved.mean,
            self.intersection_saved.max - other.intersection_saved.max,
        ];
        (differences.iter().map(|difference| difference * difference).sum::<f64>() / 4.0).sqrt()
    }
}

/// One reading of the text on one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// The scene.
    pub scene: String,
    /// The frames.
    pub frames: FrameRange,
    /// The acceleration structure.
    pub structure: Structure,
    /// The depth.
    pub depth: u32,
    /// The rule which lights get a shadow ray, in this reading.
    pub shadow_rays: ShadowRays,
    /// The policy's name.
    pub policy: String,
    /// The paper's figures.
    pub published: Figures,
    /// The measured figures; `None` if there were no shadow rays to save.
    pub ours: Option<Figures>,
    /// The best frame for node visits and for triangle tests, counted from 0 among those traced.
    pub best_frames: Option<[usize; 2]>,
    /// Wrong shadow decisions in all frames.
    pub wrong: u64,
    /// See [`Figures::distance`]; `None` without measured figures.
    pub distance: Option<f64>,
}

/// A table and all that its file names.
pub(crate) struct Table {
    spec: PaperSpec,
    /// The scenes, in the order of the file.
    scenes: Vec<Scene>,
}

impl Table {
    /// Reads the table of the file `path`.
    ///
    /// # Errors
    /// A file cannot be read or is wrong, a structure does not support a policy, or a scene has fewer frames.
    pub(crate) fn load(path: &Path) -> Result<Self, ExperimentError> {
        let spec: PaperSpec = ron_file::read(path)?;
        for &structure in &spec.structures {
            check_boxes(path, &spec.policies, structure)?;
        }
        let load = |of: &PaperScene| {
            let scene = read_scene(&named(Kind::Scene, path, &of.scene));
            let (_, scene) = scene.map_err(|error| error.named_in(path))?;
            if let Some(frames) = spec.frames.iter().find(|frames| frames.end() > scene.frame_count) {
                let what = format!("`frames` has {frames}, but `{}` has {} frames", scene.name, scene.frame_count);
                return Err(ExperimentError::from(ConfigError::Content { path: path.into(), what }));
            }
            Ok(scene)
        };
        let scenes = spec.scenes.iter().map(load).collect::<Result<_, _>>()?;
        Ok(Self { spec, scenes })
    }

    /// The number of readings to trace, each with all policies.
    pub(crate) fn readings(&self) -> usize {
        self.scenes.len() * self.spec.frames.len() * tracers(&self.spec).len()
    }
}

/// Traces all readings. When `stop` becomes true, returns the readings done.
pub(crate) fn paper_table(path: &Path, stop: &AtomicBool) -> Result<Vec<Reading>, ExperimentError> {
    let table = Table::load(path)?;
    let bar = progress::bar("paper", table.readings(), "readings");
    let Table { spec, scenes } = table;
    let mut readings = Vec::new();
    for (scene, PaperScene { published, .. }) in scenes.iter().zip(&spec.scenes) {
        for &frames in &spec.frames {
            for tracer in tracers(&spec) {
                if stop.load(Ordering::Relaxed) {
                    return Ok(readings);
                }
                readings.extend(read(&spec, scene, published, frames, tracer));
                bar.inc(1);
            }
        }
    }
    drop(bar);
    Ok(readings)
}

/// All combinations of structure, depth and shadow rays.
fn tracers(spec: &PaperSpec) -> Vec<TracerSpec> {
    let mut all = Vec::new();
    for &structure in &spec.structures {
        for depth in &spec.depths {
            for &shadow_rays in &spec.shadow_rays {
                let mut tracer = TracerSpec::default();
                tracer.accel.structure = structure;
                tracer.render.depth = depth.get() as u32;
                tracer.render.shadow_rays = shadow_rays;
                all.push(tracer);
            }
        }
    }
    all
}

/// Traces the frames once for all policies.
fn read(
    spec: &PaperSpec,
    scene: &Scene,
    published: &Figures,
    frames: FrameRange,
    tracer_spec: TracerSpec,
) -> Vec<Reading> {
    let numbers = frames.numbers();
    let tracer = Tracer::new(scene, &scene.animation.frame(numbers[0]), spec.resolution, tracer_spec);
    let named = spec.policies.iter().map(|(_, policy)| policy);
    let mut policies: Vec<_> =
        std::iter::once(&PolicySpec::Off).chain(named).map(|policy| policy.build(SceneFacts::of(scene))).collect();
    let mut results: Vec<Vec<FrameResult>> = vec![Vec::new(); policies.len()];
    for &number in &numbers {
        let frame = scene.animation.frame(number);
        let lanes = tracer.frame(&frame, &mut policies, |_, _| Ok::<_, std::convert::Infallible>(()));
        let lanes = lanes.unwrap_or_else(|never| match never {});
        for (results, lane) in results.iter_mut().zip(&lanes) {
            results.push(frame_result(number, lane));
        }
    }
    let (off, culled) = results.split_first().expect("`Off` is always the first");
    let row = |((name, _), results): ((&str, _), &Vec<FrameResult>)| {
        let summary = PolicySummary::new(results, Vec::new(), Some(off));
        let index = |number: u32| numbers.iter().position(|&frame| frame == number);
        let shares = |saved: &Saved| Some(MeanMax { mean: saved.mean?, max: saved.max? });
        let [traversal, intersection] = [&summary.traversal_saved, &summary.intersection_saved];
        let figures = || {
            Some(Figures {
                traversal_saved: shares(traversal)?,
                intersection_saved: shares(intersection)?,
                occlusion_tests_per_pixel: summary.counts.occlusion_tests_per_pixel?,
            })
        };
        let best = || Some([index(traversal.max_frame?)?, index(intersection.max_frame?)?]);
        let ours = figures();
        Reading {
            scene: scene.name.clone(),
            frames,
            structure: tracer_spec.accel.structure,
            depth: tracer_spec.render.depth,
            shadow_rays: tracer_spec.render.shadow_rays,
            policy: name.to_owned(),
            published: *published,
            ours,
            best_frames: best(),
            wrong: summary.counts.wrong().unwrap_or(0),
            distance: ours.map(|ours| ours.distance(published)),
        }
    };
    spec.policies.iter().zip(culled).map(row).collect()
}

/// The nearest reading of each scene, and a definition of the distance.
pub(crate) fn verdict(readings: &[Reading]) -> String {
    let mut scenes: Vec<&str> = readings.iter().map(|reading| reading.scene.as_str()).collect();
    scenes.dedup();
    let nearest = |scene: &&str| {
        let of_scene = readings.iter().filter(|reading| reading.scene == **scene);
        let measured = of_scene.filter_map(|reading| Some((reading.distance?, reading)));
        let (distance, reading) = measured.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
        let Reading { frames, structure, depth, shadow_rays, policy, .. } = reading;
        let points = 100.0 * distance;
        Some(format!(
            "nearest in {scene}: {policy}, {frames}, {structure:?}, depth {depth}, {shadow_rays:?}: {points:.1} points"
        ))
    };
    let distance = "distance: root mean square of the differences of the four shares, in points";
    scenes.iter().filter_map(nearest).chain([distance.to_owned()]).collect::<Vec<_>>().join("\n")
}

/// The readings of each scene, closest to the paper first, below the scene's published figures.
pub(crate) fn grid(readings: &[Reading]) -> Grid {
    const HEAD: [&str; 12] = [
        "scene",
        "reading",
        "policy",
        "nodes saved",
        "most",
        "in",
        "triangles saved",
        "most",
        "in",
        "tests/pixel",
        "wrong",
        "distance",
    ];
    let mut sorted: Vec<&Reading> = readings.iter().collect();
    // Scenes stay in order of first appearance.
    let place = |scene: &str| readings.iter().position(|reading| reading.scene == scene);
    let distance = |reading: &Reading| reading.distance.unwrap_or(f64::INFINITY);
    sorted.sort_by(|a, b| place(&a.scene).cmp(&place(&b.scene)).then(distance(a).total_cmp(&distance(b))));
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut scene = None;
    for reading in sorted {
        if scene != Some(&reading.scene) {
            scene = Some(&reading.scene);
            let [nodes, most_nodes, tests, most_tests, pixel] = texts(&reading.published);
            let dash = || "-".to_owned();
            let row = [nodes, most_nodes, dash(), tests, most_tests, dash(), pixel, dash(), dash()];
            rows.push([reading.scene.clone(), "published".to_owned(), dash()].into_iter().chain(row).collect());
        }
        let [nodes, most_nodes, tests, most_tests, pixel] = match &reading.ours {
            Some(ours) => texts(ours),
            None => [(); 5].map(|()| ABSENT.to_owned()),
        };
        let best = |at: usize| or_absent(reading.best_frames, |best| best[at].to_string());
        let Reading { frames, structure, depth, shadow_rays, .. } = reading;
        rows.push(vec![
            reading.scene.clone(),
            format!("{frames}, {structure:?}, depth {depth}, {shadow_rays:?}"),
            reading.policy.clone(),
            nodes,
            most_nodes,
            best(0),
            tests,
            most_tests,
            best(1),
            pixel,
            exact(reading.wrong),
            or_absent(reading.distance, |distance| format!("{:.1}", 100.0 * distance)),
        ]);
    }
    Grid { head: HEAD.map(Into::into).to_vec(), names: 3, rows }
}

fn texts(figures: &Figures) -> [String; 5] {
    [
        percent(figures.traversal_saved.mean),
        percent(figures.traversal_saved.max),
        percent(figures.intersection_saved.mean),
        percent(figures.intersection_saved.max),
        format!("{:.3}", figures.occlusion_tests_per_pixel),
    ]
}
