//! Compares the tracer's pictures of a frame with the reference renderer's, and makes the report's pictures of the
//! frame.

use super::load::Experiment;
use crate::culling::Policy;
use crate::quantity::PrimitiveId;
use crate::reference::Reference;
use crate::report::file_names::file_names;
use crate::report::run::Psnr;
use crate::report::run::pictures::{self, Image, PictureInfo, PictureKind};
use crate::scene::{Frame, Picture};
use crate::tracer::LaneFrame;
use crate::validate::{self, Comparison, PixelVerdict, VerdictPicture};

/// A policy's mode words of all primitives at the start of a frame; `None` if the policy keeps none.
pub(crate) struct Words(Option<Vec<u32>>);

impl Words {
    /// Copies the current words of `policy`.
    pub(crate) fn latch(policy: &dyn Policy, primitives: usize) -> Self {
        Self((0..primitives as u32).map(|primitive| policy.word(PrimitiveId(primitive))).collect())
    }
}

/// A frame compared with the reference renderer's.
pub(crate) struct Validated {
    /// The frame's number.
    pub frame: u32,
    /// The reference renderer's picture.
    pub reference: Picture,
    /// Comparison and wrong pixels of each policy, in the experiment's order.
    pub policies: Vec<(Comparison, VerdictPicture)>,
}

/// Renders the reference picture of a frame and compares the picture of every policy with it.
pub(crate) fn validate(
    experiment: &Experiment,
    reference: &Reference<'_>,
    frame: &Frame,
    offset: f64,
    lanes: &[LaneFrame],
) -> Validated {
    let truth = reference.render(frame, experiment.spec.resolution, &experiment.spec.tracer.render, offset);
    let plain = &lanes[experiment.off()].picture;
    let compare = |lane: &LaneFrame| {
        validate::compare(&truth, plain, &lane.picture, experiment.scene.light_count)
            .expect("one tracer made the pictures, of the same rays and size")
    };
    let policies = lanes.iter().map(compare).collect();
    Validated { frame: frame.number, reference: truth, policies }
}

/// How close a picture is to the reference renderer's.
pub(crate) fn psnr(comparison: &Comparison) -> Psnr {
    comparison.against_reference.psnr().map_or(Psnr::Identical, Psnr::Decibel)
}

impl Validated {
    /// The report's pictures of the frame: for each policy the render, the wrong pixels (of all lights, then of each
    /// light that has any) and the mode words towards the first light, and the reference renderer's picture.
    pub(crate) fn pictures(
        &self,
        experiment: &Experiment,
        lanes: &[LaneFrame],
        words: &[Words],
    ) -> Vec<(PictureInfo, Image)> {
        let resolution = experiment.spec.resolution;
        let mut shown = vec![(
            PictureInfo::new(PictureKind::Reference, None, self.frame),
            pictures::render(resolution, &self.reference.rgb),
        )];
        let lanes = lanes.iter().zip(words).zip(&self.policies);
        let policies = file_names(experiment.policy_names());
        for (policy, ((lane, words), (_, verdicts))) in policies.iter().zip(lanes) {
            let mut add = |kind, image| shown.push((PictureInfo::new(kind, Some(policy), self.frame), image));
            let render = pictures::render(resolution, &lane.picture.rgb);
            add(PictureKind::Difference { light: None }, pictures::difference(&render, &verdicts.all));
            for (light, verdicts) in verdicts.lights.iter().enumerate() {
                let culled_wrong = |verdict: &PixelVerdict| *verdict > PixelVerdict::Numeric;
                if verdicts.iter().any(culled_wrong) {
                    let kind = PictureKind::Difference { light: Some(light as u32) };
                    add(kind, pictures::difference(&render, verdicts));
                }
            }
            if let Words(Some(words)) = words {
                let seen: Vec<_> = lane.picture.hits.iter().map(|hit| hit.map(|hit| words[hit.0 as usize])).collect();
                add(PictureKind::Words { light: 0 }, pictures::words(resolution, &seen, 0));
            }
            add(PictureKind::Render, render);
        }
        shown
    }
}
