//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, bail};
use clap::Args;

use super::config_path::{config_path, or_other_kind};
use crate::console::{note, warn};
use crate::experiment::frames::FrameRange;
use crate::experiment::{self, Experiment, Overrides, Setting, warnings};
use crate::fields::Root;
use crate::machine::MachineSpec;
use crate::named::twice;
use crate::quantity::Resolution;

/// The experiment that a command runs, and what the command line changes in it.
#[derive(Args)]
pub(super) struct ExperimentArgs {
    /// The experiment: a file, or the name of a shipped one, such as quickstart
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
    /// Another scene than the file's: a file, the name of a shipped one, or an OBJ, PLY or glTF file, which a camera
    /// then goes round
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Trace these frames instead of the file's: A..B:STEP, B not included [example: 0..800:16]
    #[arg(long, value_name = "A..B:STEP")]
    frames: Option<FrameRange>,
    /// Trace pictures of this size instead of the file's [example: 512x512]
    #[arg(long, value_name = "WxH")]
    resolution: Option<Resolution>,
    /// Replay N frames before measured ones, and leave them out of all means [default: 1 where a policy learns]
    #[arg(long, value_name = "N")]
    warmup: Option<u32>,
    /// Set a field of the experiment or of all machines; may be given again [example: traversal.cache.bytes=16KiB]
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Setting>,
}

impl ExperimentArgs {
    /// Loads the experiment, on `machines` if there are any. Prints notices about contents of the scene's files that
    /// have no effect, and warnings about useless work.
    pub(super) fn load(&self, machines: &[PathBuf], with_machines: bool) -> Result<Experiment> {
        let path = config_path(Root::Experiment, &self.config)?;
        experiment::check_once(&self.set).map_err(anyhow::Error::msg)?;
        let overrides = Overrides {
            scene: self.scene.as_deref().map(|scene| config_path(Root::Scene, scene)).transpose()?,
            frames: self.frames,
            resolution: self.resolution,
            warmup: self.warmup,
            machines: machine_paths(machines)?,
            set: self.set.clone(),
        };
        let experiment =
            Experiment::load(&path, overrides).map_err(|error| or_other_kind(error, &path, Root::Experiment))?;
        note(format!("{}: {}", experiment.spec.name, experiment.need()));
        experiment.scene.origin.notices.iter().for_each(|notice| note(format!("note: {notice}")));
        warnings::warnings(&experiment, with_machines).iter().for_each(warn);
        Ok(experiment)
    }
}

/// The files of machines that the command line names.
fn machine_paths(machines: &[PathBuf]) -> Result<Vec<PathBuf>> {
    machines.iter().map(|machine| config_path(Root::Machine, machine)).collect()
}

/// A recorded ray stream and the machines that replay it.
#[derive(Args)]
pub(super) struct StreamAndMachine {
    /// The stream's file, from `umbrasim trace`
    pub(super) stream: PathBuf,
    /// Machines: files, or names of shipped ones; may be given again [example: small,desktop]
    #[arg(long = "machine", value_name = "MACHINE", value_delimiter = ',', required = true)]
    machines: Vec<PathBuf>,
    /// Set a field of all machines; may be given again [example: traversal.cache.bytes=16KiB]
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Setting>,
}

impl StreamAndMachine {
    /// The machines in the order of the command line.
    pub(super) fn machines(&self) -> Result<Vec<MachineSpec>> {
        experiment::check_once(&self.set).map_err(anyhow::Error::msg)?;
        let read = |path: &PathBuf| {
            let settings: Vec<&Setting> = self.set.iter().collect();
            let machine = experiment::machine_with(path, &settings);
            let machine = machine.map_err(|error| or_other_kind(error, path, Root::Machine))?;
            warnings::of_machine(path).iter().for_each(warn);
            Ok::<_, Error>(machine)
        };
        let machines: Vec<MachineSpec> = machine_paths(&self.machines)?.iter().map(read).collect::<Result<_>>()?;
        if let Some(name) = twice(machines.iter().map(|machine| &machine.name)) {
            bail!("`--machine` names two machines called `{name}`: results are told by name");
        }
        Ok(machines)
    }

    /// The machine, for a purpose `what` that allows only one.
    pub(super) fn machine(&self, what: &str) -> Result<MachineSpec> {
        let mut machines = self.machines()?;
        anyhow::ensure!(machines.len() == 1, "{what} is of one machine: {} are given", machines.len());
        Ok(machines.remove(0))
    }
}

/// The report's folder: `out`, or `reports/` with the name of the config's file.
pub(super) fn report_folder(out: Option<PathBuf>, config: &Path) -> Result<PathBuf> {
    let name = config.file_stem().with_context(|| format!("{} has no file name", config.display()))?;
    Ok(out.unwrap_or_else(|| Path::new("reports").join(name)))
}
