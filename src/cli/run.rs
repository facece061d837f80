//! `run`: an experiment from scenes to report.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use anyhow::Result;
use clap::Args;

use super::arguments::ExperimentArgs;
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::{Experiment, run};
use crate::output::{ResultsFolder, claim_folder, signals};
use crate::report;

/// Run an experiment: trace, replay, validate, and write a report
///
/// Every frame is traced once for all culling policies. Each policy's ray stream is replayed on each machine while it
/// is traced, and the pictures are compared with those of a reference renderer in double precision that shares no code
/// with the tracer. The report (numbers, plots, pictures and a page that shows all) goes to `reports/NAME`, after the
/// experiment's name. Ctrl-C ends the run after the frame in work; the report then covers the frames done, and says so.
#[derive(Args)]
pub(super) struct Run {
    #[command(flatten)]
    experiment: ExperimentArgs,
    /// Where the report goes [default: reports/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Run {
    pub(super) fn run(self) -> Result<Outcome> {
        if let Some(out) = &self.out {
            claim_folder("--out", out)?;
        }
        let experiment = self.experiment.load()?;
        let out = self.out.unwrap_or_else(|| Path::new("reports").join(&experiment.spec.name));
        run_and_report(&experiment, true, Some(&ResultsFolder::claim(&out)?))
    }
}

/// Runs `experiment`, on its machines if `machines` is set, writes its report to `out` and prints its tables.
pub(super) fn run_and_report(experiment: &Experiment, machines: bool, out: Option<&ResultsFolder>) -> Result<Outcome> {
    let stop = signals::stop_flag();
    let result = run::run(experiment, machines, &stop)?;
    let page = out.map(|out| report::write(out, &result)).transpose()?;
    print(report::run::terminal(&result.summary))?;
    if let Some(page) = page {
        print(page.display())?;
    }
    Ok(Outcome::failed_if(stop.load(Ordering::Relaxed)))
}
