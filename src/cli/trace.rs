//! `trace`: records a ray stream.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::arguments::ExperimentArgs;
use super::destinations::claim_files;
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::trace::trace;
use crate::output::signals;

/// Trace frames for one policy and record the ray stream in a file
///
/// The file describes itself (`umbrasim inspect`) and is all that `umbrasim replay` needs beside a machine.
#[derive(Args)]
pub(super) struct Trace {
    #[command(flatten)]
    experiment: ExperimentArgs,
    /// The stream's file; its folder must be there
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Which policy of the experiment [default: the first]
    #[arg(long, value_name = "NAME")]
    policy: Option<String>,
}

impl Trace {
    pub(super) fn run(self) -> Result<Outcome> {
        claim_files([("-o", Some(self.output.as_path()))])?;
        let stop = signals::stop_flag();
        trace(&self.experiment.load(&[], false)?, self.policy.as_deref(), &self.output, &stop)?;
        print(self.output.display())?;
        Ok(Outcome::Done)
    }
}
