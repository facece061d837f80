//! `sweep`: the same rays on machines that differ in named fields.

mod emit;
mod plan;
mod quote;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;

use self::emit::Script;
use self::quote::shell;
use super::arguments::report_folder;
use super::config_path::config_path;
use super::destinations::{claim_files, results_folder};
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::sweep::{self, Shard};
use crate::output::{ResultsFolder, SharedFolder, claim_folder, signals};
use crate::report;
use crate::report::sweep::SweepSummary;
use crate::shipped::Kind;

/// Replay the same rays on machines that differ in named fields
///
/// The frames of an experiment are traced once. Every replay is kept, so that a sweep that was stopped by Ctrl-C goes
/// on when it is started again. The report has a table (`sweep.csv`), a plot and a page. Shards share the work between
/// processes and machines, and --collect makes the same report of what they kept.
#[derive(Args)]
pub(super) struct Sweep {
    /// The sweep: a file, or the name of a shipped one
    #[arg(default_value = "sweep_words")]
    config: PathBuf,
    /// Where streams, points and the report go [default: reports/, the name of the sweep's file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    part: Part,
    /// Shards of --emit [default: as many as points, up to 100, or 400 for hq]
    #[arg(long, value_name = "N", requires = "emit", value_parser = clap::value_parser!(u16).range(1..))]
    shards: Option<u16>,
}

/// What is done of a sweep; everything if nothing is said.
#[derive(Args)]
#[group(multiple = false)]
struct Part {
    /// Write the points to FILE as CSV, or as JSON lines if it ends in .jsonl; - is standard output
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Record the ray streams alone
    #[arg(long)]
    record: bool,
    /// Make one of N shards of even cost; any number of shards may run at once in one folder
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Merge what shards kept in these folders and in --out, and write the report
    #[arg(long, value_name = "DIR", num_args = 0..)]
    collect: Option<Vec<PathBuf>>,
    /// Write a script that runs all shards: hq (HyperQueue), slurm (a job array) or snakemake
    #[arg(long, value_names = ["ENGINE", "FILE"], num_args = 2)]
    emit: Option<Vec<PathBuf>>,
}

impl Sweep {
    pub(super) fn run(self) -> Result<Outcome> {
        let config = config_path(Kind::Experiment, &self.config)?;
        let out = report_folder(self.out, &self.config)?;
        let stop = signals::stop_flag();
        let share = || -> Result<SharedFolder> {
            claim_folder("--out", &out)?;
            Ok(ResultsFolder::share(&out)?)
        };
        match self.part {
            Part { plan: Some(file), .. } => {
                claim_files([("--plan", Some(file.as_path()))])?;
                plan::write(&file, &sweep::list(&config)?)?;
            }
            Part { record: true, .. } => sweep::record(&config, &share()?, &stop)?,
            Part { shard: Some(shard), .. } => {
                let points = sweep::shard(&config, &share()?, shard, &stop)?;
                print(format!("shard {shard}: {points} points are in {}", out.display()))?;
            }
            Part { collect: Some(others), .. } => {
                let out = results_folder(&out)?;
                let command = |shard: Shard, folder: &Path| command(&self.config, shard, folder);
                report(&out, &sweep::collect(&config, &out, &others, command)?)?;
            }
            Part { emit: Some(emit), .. } => {
                let [engine, file] = emit.try_into().ok().context("`--emit` takes an engine and a file")?;
                claim_files([("--emit", Some(file.as_path()))])?;
                let points = sweep::list(&config)?.points.len();
                Script::new(&engine, &self.config, &out, points, self.shards)?.write(&file)?;
            }
            _ => {
                let out = results_folder(&out)?;
                report(&out, &sweep::sweep(&config, &out, &stop)?)?;
            }
        }
        Ok(Outcome::Done)
    }
}

fn report(out: &ResultsFolder, summary: &SweepSummary) -> Result<()> {
    let page = report::write(out, summary)?;
    print(report::drawn(&report::sweep::grid(summary)))?;
    print(page.display())
}

/// The command that makes a shard in a folder.
fn command(config: &Path, shard: Shard, folder: &Path) -> String {
    format!("umbrasim sweep {} --shard {shard} --out {}", shell(config), shell(folder))
}
