//! `run`: an experiment from scenes to report.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::arguments::ExperimentArgs;
use super::ending::Ending;
use super::outcome::Outcome;
use crate::console::warn;
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
    /// Machines in place of the experiment's: files, or names of shipped ones; may be given again
    /// [example: small,desktop]
    #[arg(long = "machine", value_name = "MACHINE", value_delimiter = ',')]
    machines: Vec<PathBuf>,
    /// Where the report goes [default: reports/NAME]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    ending: Ending,
}

impl Run {
    pub(super) fn run(self) -> Result<Outcome> {
        if let Some(out) = &self.out {
            claim_folder("--out", out)?;
        }
        let experiment = self.experiment.load(&self.machines, true)?;
        let out = self.out.unwrap_or_else(|| Path::new("reports").join(&experiment.spec.name));
        run_and_report(&experiment, true, Some(&ResultsFolder::claim(&out)?), &self.ending)
    }
}

/// Runs `experiment`, on its machines if `machines` is set, writes its report to `out` and prints what was found.
pub(super) fn run_and_report(
    experiment: &Experiment,
    machines: bool,
    out: Option<&ResultsFolder>,
    ending: &Ending,
) -> Result<Outcome> {
    let (begin, stop) = (Instant::now(), signals::stop_flag());
    let result = run::run(experiment, machines, &stop)?;
    let page = out.map(|out| report::write(out, &result)).transpose()?;
    let summary = &result.summary;
    if summary.sees_nothing() {
        warn("no ray of the camera met a surface that asks a light: is it turned away, or in a wall?");
    }
    let verdict = report::run::verdict(summary).unwrap_or_default();
    ending.tell(summary, &report::run::terminal(summary), &verdict, begin, page.as_deref())?;
    Ok(Outcome::failed_if(stop.load(Ordering::Relaxed)))
}
