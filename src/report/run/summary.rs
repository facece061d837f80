//! The results of a run as data: the types of `summary.json`.
//!
//! Other tools read these names: they change only together with [`SCHEMA`]. A number that was not measured is `null`
//! or left out, never zero. Only [`Summary::made`], [`Summary::wall_seconds`] and
//! [`Summary::simulated_rays_per_wall_second`] differ between two runs of the same experiment.

use std::collections::BTreeMap;
use std::ops::Deref;

use serde::{Deserialize, Serialize};

use super::machine_run::{MachineRun, share};
use super::pictures::PictureInfo;
use crate::named::Named;
use crate::quantity::Resolution;
use crate::report::split::Split;
use crate::stats::{Accuracy, FrameReuse};
use crate::stream::Totals;

/// The version of the names and their meanings.
pub(crate) const SCHEMA: u32 = 1;

/// A whole run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Summary {
    /// Always [`SCHEMA`].
    pub schema: u32,
    /// The experiment's name.
    pub experiment: String,
    /// The scene.
    pub scene: SceneSummary,
    /// Numbers of the frames, in order.
    pub frames: Vec<u32>,
    /// Size of the pictures.
    pub resolution: Resolution,
    /// Name of the policy that culls nothing, against which savings are measured.
    pub baseline: Option<String>,
    /// Results of each policy.
    pub policies: Named<PolicySummary>,
    /// Measurements of each machine.
    pub machines: Named<MachineSummary>,
    /// The pictures in the report's folder.
    pub pictures: Vec<PictureInfo>,
    /// The inputs of the run: versions, seeds, hashes of inputs, by name.
    pub provenance: Named<String>,
    /// Paths in the configuration as run of fields that differ from the defaults of machines and tracer.
    #[serde(default)]
    pub changed: Vec<String>,
    /// Command line, date and host of the run: these differ from run to run.
    #[serde(default)]
    pub made: Named<String>,
    /// Wall time by stage, in seconds.
    pub wall_seconds: Named<f64>,
    /// The simulator's own speed by stage: rays simulated per second of wall time.
    pub simulated_rays_per_wall_second: Named<f64>,
}

impl Summary {
    /// Whether the scene has lights, but the camera's rays hit nothing that needs a shadow ray.
    pub(crate) fn sees_nothing(&self) -> bool {
        let off = self.baseline.as_deref().and_then(|baseline| self.policies.get(baseline));
        self.scene.lights > 0 && off.is_some_and(|off| off.counts.primary_rays > 0 && off.counts.shadow_rays == 0)
    }
}

/// The scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct SceneSummary {
    /// Its name.
    pub name: String,
    /// Static triangles.
    pub triangles_static: u64,
    /// Triangles that can move.
    pub triangles_dynamic: u64,
    /// Lights.
    pub lights: u64,
}

/// Results of a policy: all frames together, and each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PolicySummary {
    /// Sums over all frames.
    #[serde(flatten)]
    pub counts: Counts,
    /// Share of the shadow rays' node visits saved; the policy's own visits count as costs.
    pub traversal_saved: Saved,
    /// Share of the shadow rays' triangle tests saved. The policy's own tests count as costs, except occlusion tests,
    /// which have a count of their own: [`Counts::occlusion_tests`].
    pub intersection_saved: Saved,
    /// Wrong decisions by light, if they were looked for.
    pub lights: Vec<LightWrong>,
    /// The frames.
    pub frames: Vec<FrameSummary>,
}

/// A share of work saved against the baseline; all `None` if there is no baseline, or it has no such work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Saved {
    /// Mean of the frames' shares.
    pub mean: Option<f64>,
    /// The largest share of a frame.
    pub max: Option<f64>,
    /// The first frame with the largest share.
    pub max_frame: Option<u32>,
    /// Share saved over the rays of all frames together.
    pub total: Option<f64>,
}

/// Results of a policy in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct FrameSummary {
    /// The frame's number.
    pub frame: u32,
    /// The counts.
    #[serde(flatten)]
    pub counts: Counts,
    /// Share of node visits saved.
    pub traversal_saved: Option<f64>,
    /// Share of triangle tests saved.
    pub intersection_saved: Option<f64>,
    /// The picture's quality against the reference renderer's.
    pub psnr: Option<Psnr>,
}

/// Peak signal-to-noise ratio of a picture against the reference renderer's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Psnr {
    /// No pixel differs.
    Identical,
    /// The ratio in dB.
    Decibel(f64),
}

/// Wrong shadow decisions towards one light, in all frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct LightWrong {
    /// The light's number.
    pub light: u32,
    /// Shadow rays decided dark that, traced, find the light.
    pub false_dark: u64,
    /// Shadow rays decided lit that, traced, are stopped.
    pub false_lit: u64,
}

/// Counts of a policy in one frame or several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Counts {
    /// The tracer's counts.
    #[serde(flatten)]
    pub totals: Totals,
    /// Primary rays tested against a neighbour pixel's primitive.
    pub occlusion_tests: u64,
    /// Occlusion tests per primary ray.
    pub occlusion_tests_per_pixel: Option<f64>,
    /// Shadow rays decided dark that find their light when traced; `None` if this was not checked.
    pub false_dark: Option<u64>,
    /// Shadow rays decided lit that are stopped when traced; `None` if this was not checked.
    pub false_lit: Option<u64>,
    /// Shadow rays of primary hits that were compared with the reference renderer's.
    pub compared_rays: Option<u64>,
    /// Compared rays on which the tracer (`f32`, nothing culled) and the reference renderer (`f64`) differ: rounding.
    pub numeric_differences: Option<u64>,
}

/// Makes the tracer's counts readable as fields of these counts.
impl Deref for Counts {
    type Target = Totals;

    fn deref(&self) -> &Totals {
        &self.totals
    }
}

fn known_sum(a: Option<u64>, b: Option<u64>) -> Option<u64> {
    a.zip(b).map(|(a, b)| a + b).or(a).or(b)
}

impl Counts {
    /// False dark and false lit together.
    pub(crate) fn wrong(&self) -> Option<u64> {
        Some(self.false_dark? + self.false_lit?)
    }

    /// Node visits for shadows.
    fn traversal(&self) -> u64 {
        self.shadow_node_visits + self.policy_node_visits
    }

    /// Triangle tests for shadows, without occlusion tests.
    fn intersections(&self) -> u64 {
        self.shadow_triangle_tests + self.policy_triangle_tests - self.occlusion_tests
    }

    /// All accesses for shadows: nodes, triangles, list entries, and the policy's own accesses with its writes and
    /// occlusion tests. List entries are counted for all rays together, so on a kd-tree those of other rays are
    /// included.
    fn accesses(&self) -> u64 {
        let policy = self.policy_node_visits + self.policy_triangle_tests + self.policy_reads + self.policy_writes;
        self.shadow_node_visits + self.shadow_triangle_tests + self.list_reads + policy
    }

    fn sum<'a>(frames: impl Iterator<Item = &'a Self>) -> Self {
        let absent = Some(0);
        let mut sum = Self { false_dark: absent, false_lit: absent, ..Self::default() };
        for frame in frames {
            sum.totals += frame.totals;
            sum.occlusion_tests += frame.occlusion_tests;
            // If one frame was not checked, there is no sum.
            sum.false_dark = sum.false_dark.zip(frame.false_dark).map(|(a, b)| a + b);
            sum.false_lit = sum.false_lit.zip(frame.false_lit).map(|(a, b)| a + b);
            // The reference renderer may have been used for some frames only; `compared_rays` counts the compared
            // rays.
            sum.compared_rays = known_sum(sum.compared_rays, frame.compared_rays);
            sum.numeric_differences = known_sum(sum.numeric_differences, frame.numeric_differences);
        }
        sum.occlusion_tests_per_pixel = share(sum.occlusion_tests, sum.primary_rays);
        sum
    }
}

/// Counted results of a policy in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameResult {
    /// The frame's number.
    pub frame: u32,
    /// The tracer's counts.
    pub totals: Totals,
    /// Number of occlusion tests; `totals.policy_triangle_tests` includes them.
    pub occlusion_tests: u64,
    /// See [`Counts::false_dark`].
    pub false_dark: Option<u64>,
    /// See [`Counts::false_lit`].
    pub false_lit: Option<u64>,
    /// See [`Counts::compared_rays`].
    pub compared_rays: Option<u64>,
    /// See [`Counts::numeric_differences`].
    pub numeric_differences: Option<u64>,
    /// See [`FrameSummary::psnr`].
    pub psnr: Option<Psnr>,
}

impl FrameResult {
    fn counts(&self) -> Counts {
        let totals = self.totals;
        assert!(
            self.occlusion_tests <= totals.policy_triangle_tests,
            "occlusion tests are triangle tests of the policy"
        );
        Counts {
            totals,
            occlusion_tests: self.occlusion_tests,
            occlusion_tests_per_pixel: share(self.occlusion_tests, totals.primary_rays),
            false_dark: self.false_dark,
            false_lit: self.false_lit,
            compared_rays: self.compared_rays,
            numeric_differences: self.numeric_differences,
        }
    }
}

impl PolicySummary {
    /// Sums up a policy's frames, against the baseline's results in the same frames (`None` without a baseline).
    pub(crate) fn new(frames: &[FrameResult], lights: Vec<LightWrong>, baseline: Option<&[FrameResult]>) -> Self {
        let against: BTreeMap<u32, Counts> =
            baseline.unwrap_or_default().iter().map(|result| (result.frame, result.counts())).collect();
        let summarised: Vec<FrameSummary> = frames
            .iter()
            .map(|result| {
                let counts = result.counts();
                let off = against.get(&result.frame);
                FrameSummary {
                    frame: result.frame,
                    counts,
                    traversal_saved: off.and_then(|off| saved(counts.traversal(), off.shadow_node_visits)),
                    intersection_saved: off.and_then(|off| saved(counts.intersections(), off.shadow_triangle_tests)),
                    psnr: result.psnr,
                }
            })
            .collect();
        let counts = Counts::sum(summarised.iter().map(|frame| &frame.counts));
        let all = summarised.iter().all(|frame| against.contains_key(&frame.frame));
        let off = Counts::sum(summarised.iter().filter_map(|frame| against.get(&frame.frame)));
        let total = |with, without| if all { saved(with, without) } else { None };
        Self {
            traversal_saved: Saved::new(
                summarised.iter().map(|frame| (frame.frame, frame.traversal_saved)),
                total(counts.traversal(), off.shadow_node_visits),
            ),
            intersection_saved: Saved::new(
                summarised.iter().map(|frame| (frame.frame, frame.intersection_saved)),
                total(counts.intersections(), off.shadow_triangle_tests),
            ),
            counts,
            lights,
            frames: summarised,
        }
    }
}

impl PolicySummary {
    /// Mean over the frames of the share of accesses for shadows that is saved against `baseline`. The policy's own
    /// accesses count as costs. `None` if the baseline did not run the same frames.
    pub(crate) fn accesses_saved(&self, baseline: &Self) -> Option<f64> {
        let pairs = self.frames.iter().zip(&baseline.frames);
        let same =
            self.frames.len() == baseline.frames.len() && pairs.clone().all(|(with, off)| with.frame == off.frame);
        let shares = pairs.map(|(with, off)| (with.frame, saved(with.counts.accesses(), off.counts.accesses())));
        if same { Saved::new(shares, None).mean } else { None }
    }
}

impl Saved {
    fn new(frames: impl Iterator<Item = (u32, Option<f64>)>, total: Option<f64>) -> Self {
        let known: Vec<(u32, f64)> = frames.filter_map(|(frame, share)| Some((frame, share?))).collect();
        let most = known.iter().copied().reduce(|best, next| if next.1 > best.1 { next } else { best });
        Self {
            mean: (!known.is_empty()).then(|| known.iter().map(|(_, share)| share).sum::<f64>() / known.len() as f64),
            max: most.map(|(_, share)| share),
            max_frame: most.map(|(frame, _)| frame),
            total,
        }
    }
}

fn saved(with: u64, without: u64) -> Option<f64> {
    share(with, without).map(|share| 1.0 - share)
}

/// What a change of times between two runs of a machine can claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Claim<'a> {
    /// It is exact, or has an interval.
    Known,
    /// It comes from this level, and nothing says how far off it is.
    By(&'a str),
    /// Nothing: the difference of two bounds bounds nothing.
    Nothing,
}

/// The level whose cycles are the least that any machine takes.
const LEAST: &str = "Bound";

/// Measurements of a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MachineSummary {
    /// The fidelity level of its replays.
    pub fidelity: String,
    /// Numbers of the frames that were measured, in order.
    pub frames: Vec<u32>,
    /// Numbers of the frames that it replayed before, to warm up caches and mode words.
    #[serde(default)]
    pub warmup: Vec<u32>,
    /// One run per policy's stream.
    pub policies: Named<MachineRun>,
    /// For each culling policy, what it saved and what it cost, if the replays for this were made.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub split: Named<Split>,
    /// Misses of caches of all sizes, if they were measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reuse: Option<FrameReuse>,
}

impl MachineSummary {
    /// What a change of times to `run` can claim.
    pub(crate) fn claim(&self, run: &MachineRun) -> Claim<'_> {
        match run.stats.accuracy {
            Accuracy::Exact | Accuracy::Estimated { .. } => Claim::Known,
            Accuracy::Bounded | Accuracy::Unknown if self.fidelity == LEAST => Claim::Nothing,
            Accuracy::Bounded | Accuracy::Unknown => Claim::By(&self.fidelity),
        }
    }
}
