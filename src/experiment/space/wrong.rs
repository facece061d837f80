//! Wrong pixels of policies: those whose shadows culling changed. No machine has a part in them.

use std::convert::Infallible;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::super::load::Experiment;
use super::super::progress;
use super::super::sweep::{BUILD, SweepError};
use crate::input;
use crate::output::write_whole;
use crate::report::space::PolicyPixels;
use crate::tracer::Tracer;

/// The largest file of counts, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Counts as their file holds them.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    /// What they are of: the streams' inputs, and the build of the program.
    of: String,
    checksum: String,
    policies: Vec<PolicyPixels>,
}

/// Counts wrong pixels in the measured frames, or takes the counts that are kept in `folder` of streams that are known
/// by `identity`.
///
/// # Errors
/// The counts cannot be kept, or `stop` was set.
pub(super) fn wrong_pixels(
    experiment: &Experiment,
    identity: &str,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<Vec<PolicyPixels>, SweepError> {
    let of = format!("{identity} {BUILD}");
    let path = folder.join(format!("{:032x}.pixels.json", xxh3_128(of.as_bytes())));
    if let Some(kept) = read(&path, &of) {
        return Ok(kept);
    }
    let policies = count(experiment, stop)?;
    let kept = Kept { of, checksum: checksum(&policies), policies };
    let text = serde_json::to_vec_pretty(&kept).expect("plain data, which JSON can hold");
    write_whole(&path, &text).map_err(|source| SweepError::File { path, source })?;
    Ok(kept.policies)
}

fn checksum(policies: &[PolicyPixels]) -> String {
    let text = serde_json::to_vec(policies).expect("plain data, which JSON can hold");
    format!("{:032x}", xxh3_128(&text))
}

fn read(path: &Path, of: &str) -> Option<Vec<PolicyPixels>> {
    let text = input::read_text(path, MAX_BYTES).ok()?;
    let kept: Option<Kept> = serde_json::from_str(&text).ok();
    let good = kept.filter(|kept| kept.of == of && kept.checksum == checksum(&kept.policies));
    if good.is_none() {
        eprintln!("{}: it is damaged; wrong pixels are counted again", path.display());
    }
    good.map(|kept| kept.policies)
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
