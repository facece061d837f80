//! An experiment with everything that its files name.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::files::{machine_with, named, not_set};
use super::frames::{FrameChoice, FrameRange, Replayed};
use super::need::{Amounts, Need};
use super::set::{self, Setting};
use super::spec::ExperimentSpec;
use crate::culling::{Policy, PolicySpec, SceneFacts};
use crate::machine::MachineSpec;
use crate::named::Named;
use crate::quantity::Resolution;
use crate::ron_file::{self, ConfigError, Kind};
use crate::scene::MAX_LIGHTS;
use crate::scene::composed::starter;
use crate::scene::spec::SceneSpec;
use crate::scene::{Scene, SceneError};
use crate::stream::{Step, Structure};

/// What the command line sets in place of the file.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Other frames.
    pub frames: Option<FrameRange>,
    /// Another scene: its config, or a file of triangles, which a camera goes round.
    pub scene: Option<PathBuf>,
    /// Another size of the pictures.
    pub resolution: Option<Resolution>,
    /// Another number of warm-up frames.
    pub warmup: Option<u32>,
    /// Files of machines in place of the experiment's; paths are as the command line has them.
    pub machines: Vec<PathBuf>,
    /// Fields of the experiment, or of all its machines.
    pub set: Vec<Setting>,
}

/// Why an experiment cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// A config is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl ExperimentError {
    /// Names the config at `config` in the error if a file that this config names cannot be read.
    pub(super) fn named_in(self, config: &Path) -> Self {
        match self {
            Self::Config(error) => ron_file::named_in(config, error).into(),
            other => other,
        }
    }
}

/// An experiment with everything that its files name.
pub struct Experiment {
    /// The experiment as it is run: the file's values, with those of the command line.
    pub spec: ExperimentSpec,
    /// Where the scene comes from.
    pub scene_spec: SceneSpec,
    /// The scene.
    pub scene: Scene,
    /// The machines by name.
    pub machines: Named<MachineSpec>,
    /// The machines' files.
    pub(super) machine_files: Vec<PathBuf>,
    /// Numbers of the frames, in order.
    pub frames: Vec<u32>,
    /// The frames that the machines replay.
    pub replayed: Replayed,
}

/// All that a run depends on, written beside its results.
#[derive(Serialize)]
struct AsRun<'a> {
    experiment: &'a ExperimentSpec,
    scene: &'a SceneSpec,
    machines: &'a Named<MachineSpec>,
}

/// The first part of a path that names a field of the experiment.
const EXPERIMENT: &str = "experiment";

/// Reads a scene's file and all files that it names. The file may also be a triangle mesh, which a camera circles.
///
/// # Errors
/// A file cannot be read or is wrong.
pub(crate) fn read_scene(path: &Path) -> Result<(SceneSpec, Scene), ExperimentError> {
    let is_mesh = starter::is_mesh(path);
    let spec: SceneSpec = if is_mesh {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        ron_file::parse(&starter::config(path, &name)?, path)?
    } else {
        ron_file::read(path)?
    };
    let mut scene = spec.load(path.parent().unwrap_or(Path::new(""))).map_err(|error| match error {
        SceneError::Read { path: file, source } => {
            ron_file::named_in(path, ConfigError::Read { path: file, source }).into()
        }
        other => ExperimentError::Scene(other),
    })?;
    if is_mesh {
        let name = path.display();
        scene.origin.notices.push(format!(
            "{name} has no config: a camera goes round it, under one light. `umbrasim new scene FILE.ron --mesh {name}` \
             writes that, to be changed"
        ));
    }
    Ok((spec, scene))
}

impl Experiment {
    /// Reads an experiment and all files that it names.
    ///
    /// # Errors
    /// A file cannot be read or is wrong, or the scene does not have what the experiment needs.
    pub fn load(path: &Path, overrides: Overrides) -> Result<Self, ExperimentError> {
        let mut spec = ExperimentSpec::read(path)?;
        let known = set::names(&spec);
        let is_own = |setting: &&Setting| {
            let first = setting.path.split('.').next().unwrap_or_default();
            // `warmup` is not among `known` where the file leaves it out.
            first == EXPERIMENT || first == "warmup" || known.iter().any(|name| name == first)
        };
        let (own, of_machines): (Vec<&Setting>, Vec<&Setting>) = overrides.set.iter().partition(is_own);
        let by_option = [
            ("scene", overrides.scene.is_some()),
            ("frames", overrides.frames.is_some()),
            ("resolution", overrides.resolution.is_some()),
            ("warmup", overrides.warmup.is_some()),
            ("machines", !overrides.machines.is_empty()),
        ];
        for setting in own {
            let field = setting.path.strip_prefix("experiment.").unwrap_or(&setting.path);
            let first = field.split('.').next().unwrap_or_default();
            if let Some((name, _)) = by_option.iter().find(|(name, is_given)| *is_given && *name == first) {
                let option = if *name == "machines" { "machine" } else { name };
                return Err(
                    not_set(setting, format!("`--{option}` sets `{name}` too: one of the two is enough")).into()
                );
            }
            spec = set::field(&spec, field, &setting.value).map_err(|what| not_set(setting, what))?;
        }
        let scene_path = overrides.scene.clone().unwrap_or_else(|| named(Kind::Scene, path, &spec.scene));
        spec.scene = overrides.scene.unwrap_or(spec.scene);
        spec.frames = overrides.frames.unwrap_or(spec.frames);
        spec.resolution = overrides.resolution.unwrap_or(spec.resolution);
        spec.warmup = overrides.warmup.or(spec.warmup);
        let wrong = |what: String| ConfigError::Content { path: path.into(), what };

        let mut machines = Named::default();
        let mut machine_files = Vec::new();
        if !overrides.machines.is_empty() {
            spec.machines = overrides.machines.clone();
        }
        for file in &spec.machines {
            let file = if overrides.machines.is_empty() { named(Kind::Machine, path, file) } else { file.clone() };
            let machine = machine_with(&file, &of_machines).map_err(|error| ron_file::named_in(path, error))?;
            if machines.get(&machine.name).is_some() {
                return Err(wrong(format!("`machines` names two machines called `{}`", machine.name)).into());
            }
            machines.insert(machine.name.clone(), machine);
            machine_files.push(file);
        }
        if let Some(setting) = of_machines.first().filter(|_| machines.is_empty()) {
            let what = format!("the experiment has no machines, and its own fields are {}", known.join(", "));
            return Err(not_set(setting, what).into());
        }
        let (scene_spec, scene) = read_scene(&scene_path).map_err(|error| error.named_in(path))?;
        if spec.frames.end() > scene.frame_count {
            let what = format!(
                "`frames` is {}, but `{}` has frames 0 to {}: END can be up to {}",
                spec.frames,
                scene.name,
                scene.frame_count - 1,
                scene.frame_count
            );
            return Err(wrong(what).into());
        }
        if scene.light_count > MAX_LIGHTS || scene.primitive_count() as u32 > Step::MAX_INDEX / 4 {
            let what = format!(
                "`{}` has {} lights and {} triangles: up to {MAX_LIGHTS} and {} are allowed",
                scene.name,
                scene.light_count,
                scene.primitive_count(),
                Step::MAX_INDEX / 4
            );
            return Err(wrong(what).into());
        }
        check_boxes(path, &spec.policies, spec.tracer.accel.structure)?;
        check_stores(&spec.policies, SceneFacts::of(&scene)).map_err(wrong)?;
        let frames = spec.frames.numbers();
        let warmup = spec.warmup.unwrap_or_else(|| default_warmup(&spec, &scene, &frames));
        let replayed = spec.replay.replayed(&frames, warmup as usize);
        if warmup > 0 && spec.replay != FrameChoice::Never && replayed.measured().next().is_none() {
            let traced = if frames.len() == 1 { "1 frame".into() } else { format!("{} frames", frames.len()) };
            let what = format!(
                "`warmup` is {warmup}, and of {traced} `replay` takes none behind them: no frame is left to measure"
            );
            return Err(wrong(what).into());
        }
        spec.warmup = Some(warmup);
        let experiment = Self { spec, scene_spec, scene, machines, machine_files, frames, replayed };
        experiment.need().check().map_err(wrong)?;
        Ok(experiment)
    }

    /// The approximate memory that the experiment needs.
    pub fn need(&self) -> Need {
        let facts = SceneFacts::of(&self.scene);
        let policies = self.spec.policies.iter().map(|(_, policy)| policy);
        Need::of(&Amounts {
            resolution: self.spec.resolution,
            frames: self.frames.len(),
            policies: self.spec.policies.len(),
            entries: policies.map(|policy| policy.largest_store(facts)).sum(),
            is_live: self.spec.policies.iter().any(|(_, policy)| policy.needs().live),
            lights: self.scene.light_count,
            triangles: self.scene.primitive_count(),
            machines: self.machines.iter().map(|(_, machine)| machine.footprint()).collect(),
        })
    }

    /// The warm-up frames of a run that replays all frames.
    pub fn first_frames(&self) -> &[u32] {
        &self.frames[..self.frames.len().saturating_sub(1).min(self.spec.warmup.unwrap_or(0) as usize)]
    }

    /// The experiment as run, in RON: its values, presets written out, with the contents of the files that it names.
    pub fn as_run(&self) -> String {
        // Type-erased, as in `json`: one serializer is compiled for all types.
        let as_run: &dyn erased_serde::Serialize =
            &AsRun { experiment: &self.spec, scene: &self.scene_spec, machines: &self.machines };
        let style = ron::ser::PrettyConfig::new().indentor("    ").extensions(ron_file::extensions());
        ron::ser::to_string_pretty(as_run, style).expect("specs are plain data, which RON can hold")
    }

    /// All inputs of the experiment's streams besides their own headers: the text that is hashed.
    pub(super) fn inputs(&self) -> String {
        format!("{}{}", self.as_run(), self.scene_hashes())
    }

    /// Hashes of the files that the scene was read from.
    pub(super) fn scene_hashes(&self) -> String {
        self.scene.origin.sources.iter().map(|source| format!("{:032x} ", source.hash)).collect()
    }

    /// The policies in their state before the first frame, in the order of the file.
    pub fn policies(&self) -> Vec<Box<dyn Policy>> {
        self.spec.policies.iter().map(|(_, policy)| policy.build(SceneFacts::of(&self.scene))).collect()
    }

    /// Names of the policies, in the order of the file.
    pub fn policy_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.spec.policies.iter().map(|(name, _)| name)
    }

    /// The index of the policy `Off`, the baseline of the others.
    pub fn off(&self) -> usize {
        self.spec
            .policies
            .iter()
            .position(|(_, policy)| *policy == PolicySpec::Off)
            .expect("a spec without `Off` is refused when it is read")
    }
}

/// One warm-up frame if a policy keeps state for later frames and a frame is left to measure; 0 otherwise.
fn default_warmup(spec: &ExperimentSpec, scene: &Scene, frames: &[u32]) -> u32 {
    let facts = SceneFacts::of(scene);
    let is_left = spec.replay.replayed(frames, 1).measured().next().is_some();
    u32::from(is_left && spec.policies.iter().any(|(_, policy)| policy.learns(facts)))
}

/// Refuses policies with more entries in a store than a step can number.
fn check_stores(policies: &Named<PolicySpec>, facts: SceneFacts) -> Result<(), String> {
    let most = u64::from(Step::MAX_INDEX) + 1;
    let entries = policies.iter().map(|(name, policy)| (name, policy.largest_store(facts)));
    match entries.into_iter().find(|&(_, entries)| entries > most) {
        Some((name, entries)) => Err(format!("the policy `{name}` keeps {entries} entries: up to {most} are allowed")),
        None => Ok(()),
    }
}

/// Refuses policies that need a tree of boxes if `structure` is not one.
pub(super) fn check_boxes(path: &Path, policies: &Named<PolicySpec>, structure: Structure) -> Result<(), ConfigError> {
    match policies.iter().find(|(_, policy)| policy.needs_boxes() && structure == Structure::KdTree) {
        Some((name, _)) => {
            let what = format!(
                "the policy `{name}` needs a tree of boxes: with it, `Bvh2` or `CwBvh` is allowed as structure"
            );
            Err(ConfigError::Content { path: path.into(), what })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Lamps;

    #[test]
    fn stores_that_a_step_cannot_number_are_refused() {
        let facts = |primitives| SceneFacts { statics: 0, primitives, lights: 64, lamps: Lamps::points() };
        let mut policies = Named::default();
        policies.insert("last".to_owned(), PolicySpec::LastOccluder(Default::default()));
        assert_eq!(check_stores(&policies, facts(2_097_152)), Ok(()));
        let error = check_stores(&policies, facts(2_097_153)).unwrap_err();
        assert_eq!(error, "the policy `last` keeps 134217792 entries: up to 134217728 are allowed");
    }
}
