//! Wrong pixels of policies: those whose shadows culling changed. They do not depend on the machine.

use std::convert::Infallible;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::load::Experiment;
use super::super::progress;
use super::super::sweep::{SweepError, kept};
use crate::report::space::PolicyPixels;
use crate::tracer::Tracer;

/// Counts wrong pixels in the measured frames, or reads the counts that `folder` keeps for the streams of `identity`.
///
/// # Errors
/// The counts cannot be kept, or `stop` was set.
pub(super) fn wrong_pixels(
    experiment: &Experiment,
    identity: &str,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<Vec<PolicyPixels>, SweepError> {
    let is_whole = |found: &Vec<PolicyPixels>| found.len() == experiment.spec.policies.len();
    kept(folder, "pixels", identity, is_whole, || count(experiment, stop))
}

fn count(experiment: &Experiment, stop: &AtomicBool) -> Result<Vec<PolicyPixels>, SweepError> {
    let scene = &experiment.scene;
    let first = scene.animation.frame(experiment.frames[0]);
    let tracer = Tracer::new(scene, &first, experiment.spec.resolution, experiment.spec.tracer);
    let mut policies = experiment.policies();
    let none = |name: &str| PolicyPixels { policy: name.into(), pixels: 0, wrong_pixels: 0 };
    let mut found: Vec<PolicyPixels> = experiment.policy_names().map(none).collect();
    let bar = progress::bar("counting wrong pixels", experiment.frames.len(), "frames");
    for number in &experiment.frames {
        if stop.load(Ordering::Relaxed) {
            return Err(SweepError::Stopped);
        }
        let frame = scene.animation.frame(*number);
        let Ok(lanes) = tracer.frame(&frame, &mut policies, |_, _| Ok::<_, Infallible>(()));
        if !experiment.first_frames().contains(number) {
            let plain = &lanes[experiment.off()].picture.shadows;
            for (counts, lane) in found.iter_mut().zip(&lanes) {
                counts.pixels += plain.len() as u64;
                counts.wrong_pixels += plain.iter().zip(&lane.picture.shadows).filter(|(a, b)| a != b).count() as u64;
            }
        }
        bar.inc(1);
    }
    Ok(found)
}
