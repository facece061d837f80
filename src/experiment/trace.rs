//! Records the stream of one policy in a file.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::load::Experiment;
use super::progress;
use crate::stream::{Header, StreamError, StreamWriter};
use crate::tracer::Tracer;

/// Why no stream was recorded.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TraceError {
    /// The file cannot be written.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// There is no such policy.
    #[error("the experiment has no policy `{name}`; it has {known}")]
    UnknownPolicy {
        /// The name asked for.
        name: String,
        /// The names of the experiment's policies.
        known: String,
    },
    /// Stopped before all frames were traced.
    #[error("stopped before all frames were traced; nothing was written")]
    Stopped,
}

/// Traces all frames for the policy named `policy` (by default the first one), and writes its stream to `path`.
pub(crate) fn trace(
    experiment: &Experiment,
    policy: Option<&str>,
    path: &Path,
    stop: &AtomicBool,
) -> Result<(), TraceError> {
    let names: Vec<&str> = experiment.policy_names().collect();
    let wanted = policy.unwrap_or(names[0]);
    let index = names.iter().position(|&name| name == wanted).ok_or_else(|| TraceError::UnknownPolicy {
        name: wanted.to_owned(),
        known: names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
    })?;
    let scene = &experiment.scene;
    let first = scene.animation.frame(experiment.frames[0]);
    let tracer = Tracer::new(scene, &first, experiment.spec.resolution, experiment.spec.tracer);
    let mut policies = vec![experiment.policies().swap_remove(index)];
    let header = Header {
        warmup: experiment.first_frames().to_vec(),
        ..tracer.header(wanted, policies[0].as_ref(), experiment.frames.clone(), &experiment.inputs())
    };
    let mut writer = StreamWriter::create(path, &header)?;
    let bar = progress::bar("tracing", experiment.frames.len(), "frames");
    for &number in &experiment.frames {
        if stop.load(Ordering::Relaxed) {
            return Err(TraceError::Stopped);
        }
        tracer.frame(&scene.animation.frame(number), &mut policies, |_, item| writer.write(&item))?;
        bar.inc(1);
    }
    drop(bar);
    Ok(writer.finish()?)
}
