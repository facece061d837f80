//! Makes the report of a run from its results.

use std::time::{Instant, SystemTime};

use super::super::changed::changed;
use super::super::frame_reuse::Failed;
use super::super::load::Experiment;
use super::super::replay::Finished;
use super::failure::RunFailure;
use super::gathered::Gathered;
use super::measured::Measured;
use super::stages::{Clock, Stages};
use crate::named::Named;
use crate::report::run::{RunFiles, SCHEMA, SceneSummary, Summary};
use crate::stats::FrameReuse;
use crate::stream::Header;

/// What the machines did: the results of all replays, and the reuse distances of each machine.
pub(super) type Machines = (Vec<Finished>, Result<Named<FrameReuse>, Failed>);

/// The files of the report on the frames done.
///
/// # Errors
/// A machine failed, or a picture cannot be made.
pub(super) fn report(
    experiment: &Experiment,
    headers: &[Header],
    gathered: Gathered,
    (finished, reuse): Machines,
    clock: Clock,
    begin: Instant,
) -> Result<RunFiles, RunFailure> {
    let (names, off): (Vec<&str>, _) = (experiment.policy_names().collect(), experiment.off());
    let mut stages = Stages::default();
    let traced = gathered.results[off].iter().map(|frame| frame.totals);
    let rays = traced.map(|it| it.primary_rays + it.secondary_rays + it.shadow_rays).sum();
    stages.add("trace", clock.trace, Some(rays));
    stages.add("reference", clock.reference, None);
    stages.add("machines", clock.machines, None);
    let measured = Measured::new(finished, &names, &mut stages)?;
    let failed = |Failed { machine, policy, source }| RunFailure::Machine { machine, policy, source };
    let machines = measured.summaries(experiment, headers, &gathered, &reuse.map_err(failed)?);
    stages.add("total", begin.elapsed(), None);

    let summary = Summary {
        schema: SCHEMA,
        experiment: experiment.spec.name.clone(),
        scene: scene(experiment),
        policies: gathered.policies(&names, off).collect(),
        resolution: experiment.spec.resolution,
        baseline: Some(names[off].to_owned()),
        machines,
        pictures: Vec::new(),
        provenance: provenance(experiment, headers, gathered.frames.len()),
        changed: changed(experiment),
        made: made(),
        wall_seconds: stages.wall_seconds,
        simulated_rays_per_wall_second: stages.speeds,
        frames: gathered.frames,
    };
    let pictures: Vec<_> = gathered.first.into_iter().chain(gathered.worst).collect();
    Ok(RunFiles { over_time: measured.over_time, ..RunFiles::new(summary, experiment.as_run(), &pictures)? })
}

fn scene(experiment: &Experiment) -> SceneSummary {
    let scene = &experiment.scene;
    SceneSummary {
        name: scene.name.clone(),
        triangles_static: scene.statics.len() as u64,
        triangles_dynamic: scene.dynamic_count as u64,
        lights: scene.light_count as u64,
    }
}

/// What the results follow from: the program and its input. `done` is the number of frames done.
fn provenance(experiment: &Experiment, headers: &[Header], done: usize) -> Named<String> {
    let mut provenance: Named<String> = Named::default();
    provenance.insert("umbrasim", env!("CARGO_PKG_VERSION").to_owned());
    if let Some(commit) = option_env!("UMBRASIM_COMMIT") {
        provenance.insert("commit", commit.to_owned());
    }
    for header in headers {
        provenance.insert(format!("input hash of `{}`", header.policy), format!("{:016x}", header.input_hash));
    }
    for (number, notice) in experiment.scene.origin.notices.iter().enumerate() {
        provenance.insert(format!("note {} of the scene", number + 1), notice.clone());
    }
    if done < experiment.frames.len() {
        provenance.insert("stopped early", format!("{done} of {} frames", experiment.frames.len()));
    }
    provenance
}

/// How and where the program was started.
fn made() -> Named<String> {
    let quoted = |word: String| if word.contains(char::is_whitespace) { format!("'{word}'") } else { word };
    let words = std::env::args_os().map(|word| quoted(word.to_string_lossy().into_owned()));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut made: Named<String> = Named::default();
    made.insert("command line", words.collect::<Vec<_>>().join(" "));
    made.insert("date", humantime::format_rfc3339_seconds(SystemTime::now()).to_string());
    #[cfg(unix)]
    made.insert("host", rustix::system::uname().nodename().to_string_lossy().into_owned());
    made.insert("cores", cores.to_string());
    made
}
