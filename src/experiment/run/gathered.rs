//! The functional results of a run: what the tracer counted, and how the pictures compare with the reference.

use super::super::load::Experiment;
use super::super::validation::{self, Validated, Words};
use crate::report::run::pictures::{Image, PictureInfo};
use crate::report::run::{FrameResult, LightWrong, PolicySummary};
use crate::stream::Totals;
use crate::tracer::{LaneFrame, WrongDecisions};

/// A policy's results in a frame by the tracer's counts, without the reference renderer.
pub(in crate::experiment) fn frame_result(frame: u32, lane: &LaneFrame) -> FrameResult {
    FrameResult {
        frame,
        totals: lane.totals,
        occlusion_tests: lane.occlusion_tests,
        false_dark: Some(lane.wrong.iter().map(|wrong| wrong.false_dark).sum()),
        false_lit: Some(lane.wrong.iter().map(|wrong| wrong.false_lit).sum()),
        compared_rays: None,
        numeric_differences: None,
        psnr: None,
    }
}

/// The results of the frames done.
pub(super) struct Gathered {
    pub frames: Vec<u32>,
    /// The frames that the machines measured, and their warm-up frames.
    pub measured: Vec<u32>,
    pub warmup: Vec<u32>,
    /// By policy, the counts of the measured frames.
    pub totals: Vec<Totals>,
    /// By policy, then frame.
    pub results: Vec<Vec<FrameResult>>,
    /// By policy, then light.
    wrong: Vec<Vec<WrongDecisions>>,
    /// Pictures of the first frame that was validated.
    pub first: Vec<(PictureInfo, Image)>,
    /// Pictures of the validated frame with the most wrong pixels, if any is wrong.
    pub worst: Vec<(PictureInfo, Image)>,
    worst_wrong: u64,
}

impl Gathered {
    /// No frame yet.
    pub(super) fn new(experiment: &Experiment) -> Self {
        let policies = experiment.spec.policies.len();
        Self {
            frames: Vec::new(),
            measured: Vec::new(),
            warmup: Vec::new(),
            totals: vec![Totals::default(); policies],
            results: vec![Vec::new(); policies],
            wrong: vec![vec![WrongDecisions::default(); experiment.scene.light_count]; policies],
            first: Vec::new(),
            worst: Vec::new(),
            worst_wrong: 0,
        }
    }

    /// Adds a frame: what the tracer counted for each policy, and the comparison if there was one.
    pub(super) fn add(
        &mut self,
        experiment: &Experiment,
        frame: u32,
        lanes: &[LaneFrame],
        validated: Option<(Validated, Vec<Words>)>,
    ) {
        self.frames.push(frame);
        for (policy, lane) in lanes.iter().enumerate() {
            let comparison = validated.as_ref().map(|(validated, _)| &validated.policies[policy].0);
            self.results[policy].push(FrameResult {
                compared_rays: comparison.map(|comparison| comparison.all_lights().asked),
                numeric_differences: comparison.map(|comparison| comparison.all_lights().numeric_differences),
                psnr: comparison.map(validation::psnr),
                ..frame_result(frame, lane)
            });
            for (all, here) in self.wrong[policy].iter_mut().zip(&lane.wrong) {
                all.false_dark += here.false_dark;
                all.false_lit += here.false_lit;
            }
        }
        let Some((validated, words)) = validated else { return };
        let all = validated.policies.iter().map(|(comparison, _)| comparison.all_lights());
        let wrong = all.map(|counts| counts.false_dark + counts.false_lit).sum();
        if self.first.is_empty() {
            self.first = validated.pictures(experiment, lanes, &words);
        } else if wrong > self.worst_wrong {
            self.worst = validated.pictures(experiment, lanes, &words);
            self.worst_wrong = wrong;
        }
    }

    /// The policies' results; `off` is the policy without culling, which all are compared with.
    pub(super) fn policies<'a>(
        &'a self,
        names: &'a [&str],
        off: usize,
    ) -> impl Iterator<Item = (&'a str, PolicySummary)> + use<'a> {
        names.iter().zip(&self.results).zip(&self.wrong).map(move |((&name, results), wrong)| {
            let lights = wrong.iter().enumerate().map(|(light, wrong)| LightWrong {
                light: light as u32,
                false_dark: wrong.false_dark,
                false_lit: wrong.false_lit,
            });
            (name, PolicySummary::new(results, lights.collect(), Some(&self.results[off])))
        })
    }
}
