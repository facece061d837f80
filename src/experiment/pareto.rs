//! Speed against accuracy: all fidelity levels replay the same streams and are compared with an exact level, the
//! truth.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use schemars::JsonSchema;
use serde::Deserialize;

use super::files::{named, read_machine};
use super::frames::FrameRange;
use super::load::{Experiment, Overrides};
use super::progress;
use super::spec::ExperimentSpec;
use super::sweep::{Streams, SweepError, replay};
use crate::culling::PolicySpec;
use crate::machine::MachineSpec;
use crate::named::twice;
use crate::output::TemporaryFolder;
use crate::quantity::Resolution;
use crate::replay::{Fidelity, RunError};
use crate::report::pareto::{Figures, Found, Measured, ParetoSummary, Run, Timing};
use crate::ron_file::{self, ConfigError, Kind};

/// Compares fidelity levels: all replay the same streams, and a reference level gives the true figures.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParetoSpec {
    /// Experiments that give scenes and policies. Paths are relative to this file.
    experiments: Vec<Source>,
    /// The machines' files.
    machines: Vec<PathBuf>,
    /// The fidelity levels to compare.
    rungs: Vec<Fidelity>,
    /// The reference level: errors are differences from its figures.
    #[serde(default)]
    truth: Fidelity,
}

/// An experiment, and overrides of its fields.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Source {
    /// The experiment's file.
    file: PathBuf,
    /// Overrides the experiment's frames.
    #[serde(default)]
    frames: Option<FrameRange>,
    /// Overrides the experiment's resolution.
    #[serde(default)]
    resolution: Option<Resolution>,
    /// Names of the policies to use; an empty list means all. `Off` is always used.
    #[serde(default)]
    policies: Vec<String>,
}

/// A comparison and everything that its files name.
pub struct Comparison {
    /// The experiments, with the policies that take part.
    pub experiments: Vec<Experiment>,
    /// The machines.
    pub machines: Vec<MachineSpec>,
    /// The truth, then the levels that are compared with it.
    pub rungs: Vec<Fidelity>,
}

impl Comparison {
    /// Reads the comparison of the file `path`; `truth` replaces the file's truth.
    ///
    /// # Errors
    /// A file cannot be read or is wrong, the truth is not exact, or a list is empty.
    pub fn load(path: &Path, truth: Option<Fidelity>) -> Result<Self, SweepError> {
        let spec: ParetoSpec = ron_file::read(path)?;
        let truth = truth.unwrap_or(spec.truth);
        let wrong = |what: String| ConfigError::Content { path: path.into(), what };
        if !truth.is_exact() {
            return Err(wrong(format!("`truth` is {truth}: Event and Cycle are allowed")).into());
        }
        let experiments = spec.experiments.iter().map(|source| source.load(path)).collect::<Result<Vec<_>, _>>()?;
        let machines = spec.machines.iter().map(|file| read_machine(&named(Kind::Machine, path, file)));
        let machines = machines.collect::<Result<Vec<_>, _>>().map_err(|error| ron_file::named_in(path, error))?;
        if let Some(name) = twice(machines.iter().map(|machine| &machine.name)) {
            return Err(wrong(format!("`machines` names two machines called `{name}`")).into());
        }
        let streams: Vec<String> = experiments.iter().map(streams_of).collect();
        if let Some(name) = twice(&streams) {
            return Err(wrong(format!("`experiments` names {name} twice")).into());
        }
        for (count, what) in
            [(experiments.len(), "experiments"), (machines.len(), "machines"), (spec.rungs.len(), "rungs")]
        {
            if count == 0 {
                return Err(wrong(format!("`{what}` is empty: at least one is needed")).into());
            }
        }
        Ok(Self { experiments, machines, rungs: std::iter::once(truth).chain(spec.rungs).collect() })
    }

    /// The name of each experiment's scene; where several experiments share a scene, with what tells them apart.
    fn scenes(&self) -> impl Iterator<Item = String> {
        self.experiments.iter().map(|experiment| {
            let name = &experiment.scene.name;
            let is_alone = self.experiments.iter().filter(|other| other.scene.name == *name).count() == 1;
            if is_alone { name.clone() } else { streams_of(experiment) }
        })
    }

    /// The number of replays of the comparison.
    pub(crate) fn replays(&self) -> usize {
        let streams: usize = self.experiments.iter().map(|experiment| experiment.spec.policies.len()).sum();
        streams * self.machines.len() * self.rungs.len()
    }
}

/// The name of an experiment's scene, with its own name, frames and resolution.
fn streams_of(experiment: &Experiment) -> String {
    let ExperimentSpec { name, frames, resolution, .. } = &experiment.spec;
    format!("{} of `{name}`, {frames}, {resolution}", experiment.scene.name)
}

/// Runs the comparison of the file `path`; `truth` replaces the file's truth. Returns also the time of each level.
pub(crate) fn pareto(
    path: &Path,
    truth: Option<Fidelity>,
    stop: &AtomicBool,
) -> Result<(ParetoSummary, Vec<Timing>), SweepError> {
    compare(path, truth, stop).map_err(|error| match error {
        SweepError::Stopped => SweepError::Dropped,
        error => error,
    })
}

fn compare(
    path: &Path,
    truth: Option<Fidelity>,
    stop: &AtomicBool,
) -> Result<(ParetoSummary, Vec<Timing>), SweepError> {
    let comparison = Comparison::load(path, truth)?;
    let bar = progress::bar("replaying", comparison.replays(), "replays");
    let scenes: Vec<String> = comparison.scenes().collect();
    let Comparison { experiments, machines, rungs } = comparison;
    let truth = rungs[0];
    let mut timings: Vec<Timing> =
        rungs.iter().map(|rung| Timing { rung: rung.to_string(), seconds: 0.0, truth_seconds: 0.0, rays: 0 }).collect();
    let mut runs = Vec::new();
    for (experiment, scene) in experiments.iter().zip(scenes) {
        let folder = TemporaryFolder::create();
        let folder = folder.map_err(|source| SweepError::File { path: std::env::temp_dir(), source })?;
        let recorded = Streams::new(experiment, folder.path()).have(|_| false, stop)?;
        for machine in &machines {
            for (policy, stream) in recorded.iter().enumerate() {
                let timed = |rung| {
                    let begin = Instant::now();
                    let stats = replay(machine, (rung, None), stream, stop);
                    bar.inc(1);
                    stats.map(|stats| (stats, begin.elapsed().as_secs_f64()))
                };
                // Replays run one after another, since their times are compared.
                let (stats, truth_seconds) = timed(truth)?;
                let truth = Figures::of(&stats);
                timings[0].add(truth_seconds, truth_seconds, stream.rays());
                let mut found = Vec::new();
                for (rung, timing) in rungs.iter().zip(&mut timings).skip(1) {
                    found.push(match timed(*rung) {
                        Ok((stats, seconds)) => {
                            timing.add(seconds, truth_seconds, stream.rays());
                            Found::Measured(Measured::of(stats))
                        }
                        Err(error) => Found::Refused { refused: refusal(error)? },
                    });
                }
                runs.push(Run {
                    scene: scene.clone(),
                    machine: machine.name.clone(),
                    clock_mhz: machine.clock_mhz.get(),
                    policy: stream.header.policy.clone(),
                    is_baseline: policy == experiment.off(),
                    truth,
                    rungs: found,
                });
            }
        }
    }
    drop(bar);
    let names = rungs.iter().skip(1).map(Fidelity::to_string).collect();
    Ok((ParetoSummary::new(truth.to_string(), names, runs), timings))
}

impl Source {
    fn load(&self, path: &Path) -> Result<Experiment, SweepError> {
        let overrides = Overrides { frames: self.frames, resolution: self.resolution, ..Overrides::default() };
        let experiment = Experiment::load(&named(Kind::Experiment, path, &self.file), overrides);
        let mut experiment = experiment.map_err(|error| error.named_in(path))?;
        let policies = &experiment.spec.policies;
        if let Some(unknown) = self.policies.iter().find(|name| policies.get(name).is_none()) {
            let known: Vec<_> = policies.iter().map(|(name, _)| format!("`{name}`")).collect();
            let what = format!("{} has no policy `{unknown}`; it has {}", self.file.display(), known.join(", "));
            return Err(ConfigError::Content { path: path.into(), what }.into());
        }
        let takes_part = |&(name, policy): &(&str, &PolicySpec)| {
            self.policies.is_empty() || *policy == PolicySpec::Off || self.policies.iter().any(|wanted| wanted == name)
        };
        experiment.spec.policies =
            policies.iter().filter(takes_part).map(|(name, policy)| (name.to_owned(), policy.clone())).collect();
        Ok(experiment)
    }
}

/// Why a level refused a run that the truth did not refuse: its sample has no window, or it does not support the
/// machine's placement of mode words.
fn refusal(error: SweepError) -> Result<String, SweepError> {
    match error {
        SweepError::Machine { source, .. } if matches!(*source, RunError::Sample { .. } | RunError::Spec(_)) => {
            Ok(source.to_string())
        }
        error => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::pareto::Rung;

    /// A sample of a short stream may have no result: the others' results are still reported. `Profile` supports mode
    /// words in triangle records.
    #[test]
    fn a_rung_that_refuses_a_run_stops_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let machine = folder.path().join("in_records.ron");
        std::fs::write(&machine, "(name: \"in_records\", shadow_cache: (place: Triangle, layout: Record))").unwrap();
        let text = format!(
            "(experiments: [(file: {:?}, frames: \"0..1\", resolution: (width: 16, height: 16), policies: [\"Published\"])],
              machines: [{machine:?}], rungs: [Bound, Profile, Sampled(engine: Event, rate: 0.02)])",
            configs.join("experiments/policies_room.ron"),
        );
        let file = folder.path().join("pareto.ron");
        std::fs::write(&file, text).unwrap();
        let (summary, timings) = pareto(&file, None, &AtomicBool::new(false)).unwrap();
        let [bound, profile, sampled] = summary.rungs.as_slice() else { panic!("{:?}", summary.rungs) };
        assert!([bound, profile].iter().all(|rung| rung.refusals.is_empty() && rung.cycles.is_some()));
        let why = |rung: &Rung| rung.refusals.first().cloned().unwrap_or_default();
        assert!(why(sampled).contains("on `in_records` under `Off`: "), "{}", why(sampled));
        assert!(why(sampled).contains("is too small to tell anything: take Auto or Event"), "{}", why(sampled));
        assert_eq!((sampled.refusals.len(), sampled.cycles), (2, None));
        assert_eq!(timings.iter().map(|timing| timing.rays > 0).collect::<Vec<_>>(), [true, true, true, false]);
    }
}
