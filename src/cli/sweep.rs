//! `sweep`: the same rays on machines that differ in named fields.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::arguments::report_folder;
use super::destinations::results_folder;
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::sweep;
use crate::output::signals;
use crate::report;

/// Replay the same rays on machines that differ in named fields
///
/// The frames of an experiment are traced once. Every replay is kept, so that a sweep that was stopped by Ctrl-C goes
/// on when it is started again. The report has a table (`sweep.csv`), a plot and a page.
#[derive(Args)]
pub(super) struct Sweep {
    /// The sweep's file
    #[arg(default_value = "configs/experiments/sweep_words.ron")]
    config: PathBuf,
    /// Where streams, points and the report go [default: reports/, the name of the sweep's file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Sweep {
    pub(super) fn run(self) -> Result<Outcome> {
        let out = results_folder(&report_folder(self.out, &self.config)?)?;
        let stop = signals::stop_flag();
        let summary = sweep::sweep(&self.config, &out, &stop)?;
        let page = report::write(&out, &summary)?;
        print(report::drawn(&report::sweep::grid(&summary)))?;
        print(page.display())?;
        Ok(Outcome::Done)
    }
}
