//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;

use crate::experiment::frames::FrameRange;
use crate::experiment::{self, Experiment, Overrides};
use crate::machine::MachineSpec;
use crate::quantity::Resolution;

/// The experiment that a command runs, and what the command line changes in it.
#[derive(Args)]
pub(super) struct ExperimentArgs {
    /// The experiment's file, such as configs/experiments/quickstart.ron
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
    /// Trace these frames instead of the file's: A..B:STEP, B not included [example: 0..800:16]
    #[arg(long, value_name = "A..B:STEP")]
    frames: Option<FrameRange>,
    /// Trace pictures of this size instead of the file's [example: 512x512]
    #[arg(long, value_name = "WxH")]
    resolution: Option<Resolution>,
}

impl ExperimentArgs {
    /// Loads the experiment, and tells what of the scene's files has no effect.
    pub(super) fn load(&self) -> Result<Experiment> {
        let overrides = Overrides { frames: self.frames, resolution: self.resolution };
        let experiment = Experiment::load(&self.config, overrides)?;
        eprintln!("{}: {}", experiment.spec.name, experiment.need());
        experiment.scene.origin.notices.iter().for_each(|notice| eprintln!("note: {notice}"));
        Ok(experiment)
    }
}

/// A recorded ray stream and the machine that replays it.
#[derive(Args)]
pub(super) struct StreamAndMachine {
    /// The stream's file, from `umbrasim trace`
    pub(super) stream: PathBuf,
    /// The machine's file, such as configs/machines/small.ron
    #[arg(long, value_name = "FILE")]
    machine: PathBuf,
}

impl StreamAndMachine {
    pub(super) fn machine(&self) -> Result<MachineSpec> {
        Ok(experiment::read_machine(&self.machine)?)
    }
}

/// The report's folder: `out`, or `reports/` with the name of the config's file.
pub(super) fn report_folder(out: Option<PathBuf>, config: &Path) -> Result<PathBuf> {
    let name = config.file_stem().with_context(|| format!("{} has no file name", config.display()))?;
    Ok(out.unwrap_or_else(|| Path::new("reports").join(name)))
}
