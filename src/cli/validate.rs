//! `validate`: pictures and shadow decisions without machines.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::arguments::ExperimentArgs;
use super::destinations::results_folder;
use super::ending::Ending;
use super::outcome::Outcome;
use super::run::run_and_report;

/// Compare pictures and shadow decisions with the reference's
///
/// Prints, for each policy, wrong decisions (false dark, false lit: against the same ray traced without culling) and
/// numeric differences (rounding: the tracer without culling against the reference in double precision).
#[derive(Args)]
pub(super) struct Validate {
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    ending: Ending,
    /// Write a report with the pictures too
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Validate {
    pub(super) fn run(self) -> Result<Outcome> {
        let out = self.out.as_deref().map(results_folder).transpose()?;
        run_and_report(&self.experiment.load(&[], false)?, false, out.as_ref(), &self.ending)
    }
}
