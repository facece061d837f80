//! `sweep`: the same rays on machines that differ in named fields.

mod emit;
mod plan;
mod quote;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::Args;

use self::emit::Script;
use self::quote::shell;
use super::arguments::report_folder;
use super::config_path::{config_path, or_other_kind};
use super::destinations::{claim_files, results_folder};
use super::ending::Ending;
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::space::space;
use crate::experiment::sweep::{self, ChosenLevel, Shard};
use crate::fields::Root;
use crate::output::{ResultsFolder, SharedFolder, claim_folder, signals};
use crate::replay::{Fidelity, Share};
use crate::report;
use crate::report::space::SpaceSummary;
use crate::report::sweep::SweepSummary;

/// Replay the same rays on machines that differ in named fields
///
/// The frames of an experiment are traced once. Every replay is kept, so that a sweep that was stopped by Ctrl-C goes
/// on when it is started again. The report has a table (`sweep.csv`), a plot and a page. Shards share the work between
/// processes and machines, and --collect makes the same report of what they kept. Of a space of machines (`points:
/// Space(budget: 60)`) a few are replayed and the others predicted; shards make its first set.
#[derive(Args)]
pub(super) struct Sweep {
    /// The sweep: a file, or the name of a shipped one
    #[arg(default_value = "sweep_words")]
    config: PathBuf,
    /// Where streams, points and the report go [default: reports/, the name of the sweep's file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The fidelity level, in place of the file's: Bound, Profile, Event, Cycle, Sampled(engine: Event, rate: 0.05), or
    /// Auto(error: 0.02)
    #[arg(long, value_name = "LEVEL")]
    fidelity: Option<Fidelity>,
    /// Sample, with more and more windows, until the 95 % intervals of cycles and of L2 and DRAM bytes, and those of
    /// their changes from policy to policy and from machine to machine, are within this share [example: 1%]
    #[arg(long, value_name = "SHARE")]
    target_error: Option<Share>,
    #[command(flatten)]
    part: Part,
    /// Shards of --emit [default: as many as points, up to 100, or 400 for hq]
    #[arg(long, value_name = "N", requires = "emit", conflicts_with_all = ["plan", "record", "shard", "collect"])]
    #[arg(value_parser = clap::value_parser!(u16).range(1..))]
    shards: Option<u16>,
    /// Threads of a shard of --emit: those of the program, which every command has.
    #[arg(skip)]
    pub(super) threads: Option<u16>,
    #[command(flatten)]
    ending: Ending,
}

/// Columns that a terminal needs: the point's names, and changes of cycles and DRAM bytes.
const NEEDED: usize = 5;

/// Designs of a front that a terminal shows.
const MOST_ROWS: usize = 24;

/// What is done of a sweep; everything if nothing is said.
#[derive(Args)]
#[group(multiple = false)]
struct Part {
    /// Write the points to FILE as CSV, or as JSON lines if it ends in .jsonl, .ndjson or .json; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    plan: Option<PathBuf>,
    /// Record the ray streams alone
    #[arg(long, conflicts_with = "json")]
    record: bool,
    /// Make one of N shards of even cost; any number of shards may run at once in one folder
    #[arg(long, value_name = "I/N", conflicts_with = "json")]
    shard: Option<Shard>,
    /// Merge what shards kept in these folders and in --out, and write the report
    #[arg(long, value_name = "DIR", num_args = 0..)]
    collect: Option<Vec<PathBuf>>,
    /// Write a script that runs all shards: hq (HyperQueue), slurm (a job array) or snakemake
    #[arg(long, value_names = ["ENGINE", "FILE"], num_args = 2, conflicts_with = "json")]
    emit: Option<Vec<PathBuf>>,
}

impl Sweep {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        let config = config_path(Root::Sweep, &self.config)?;
        let out = report_folder(self.out, &self.config)?;
        let level = ChosenLevel { fidelity: self.fidelity, target_error: self.target_error };
        let words = level_words(level);
        let stop = signals::stop_flag();
        let budget = sweep::budget(&config);
        let is_space = budget.map_err(|error| or_other_kind(error, &config, Root::Sweep))?.is_some();
        let share = || -> Result<SharedFolder> {
            claim_folder("--out", &out)?;
            Ok(ResultsFolder::share(&out)?)
        };
        match self.part {
            Part { plan: Some(file), .. } => {
                claim_files([("--plan", Some(file.as_path()))])?;
                plan::write(&file, &sweep::list(&config, level)?)?;
            }
            Part { record: true, .. } => sweep::record(&config, level, &share()?, &stop)?,
            Part { shard: Some(shard), .. } => {
                let points = sweep::shard(&config, level, &share()?, shard, &stop)?;
                print(format!("shard {shard}: {points} points are in {}", out.display()))?;
            }
            Part { collect: Some(_), .. } if is_space => bail!(not_of_a_space("--collect", &self.config, &out)),
            Part { emit: Some(_), .. } if is_space => bail!(not_of_a_space("--emit", &self.config, &out)),
            Part { collect: Some(others), .. } => {
                if let Some(absent) = others.iter().find(|folder| !folder.is_dir()) {
                    bail!("--collect {}: there is no such folder", absent.display());
                }
                let out = results_folder(&out)?;
                let command = |shard: Shard, folder: &Path| {
                    format!("umbrasim sweep {}{words} --shard {shard} --out {}", shell(&self.config), shell(folder))
                };
                report(&out, &sweep::collect(&config, level, &out, &others, command)?, &self.ending, begin)?;
            }
            Part { emit: Some(emit), .. } => {
                let [engine, file] = emit.try_into().ok().context("`--emit` takes an engine and a file")?;
                claim_files([("--emit", Some(file.as_path()))])?;
                let points = sweep::list(&config, level)?.points.len();
                Script::new(&engine, (&self.config, &words), &out, points, (self.shards, self.threads))?
                    .write(&file)?;
            }
            _ if is_space => {
                let out = results_folder(&out)?;
                report_space(&out, &space(&config, level, &out, &stop)?, &self.ending, begin)?;
            }
            _ => {
                let out = results_folder(&out)?;
                report(&out, &sweep::sweep(&config, level, &out, &stop)?, &self.ending, begin)?;
            }
        }
        Ok(Outcome::Done)
    }
}

/// Writes the report and prints what was found.
fn report(out: &ResultsFolder, summary: &SweepSummary, ending: &Ending, begin: Instant) -> Result<()> {
    let page = report::write(out, summary)?;
    let table = report::drawn_most(&report::sweep::grid(summary), NEEDED);
    let table = format!("{} of {}\n\n{table}", report::sweep::frames(summary), summary.resolution);
    ending.tell(summary, &table, &report::sweep::finding(summary), begin, Some(&page))
}

/// Writes a space's report and prints what was found.
fn report_space(out: &ResultsFolder, summary: &SpaceSummary, ending: &Ending, begin: Instant) -> Result<()> {
    let page = report::write(out, summary)?;
    let tables = [
        report::drawn(&summary.front_grid(MOST_ROWS)),
        report::drawn(&summary.accuracy_grid()),
        report::paragraph(&summary.scope()),
    ];
    ending.tell(summary, &tables.join("\n\n"), &summary.finding(), begin, Some(&page))
}

/// The message that a space does not take an option.
fn not_of_a_space(option: &str, config: &Path, out: &Path) -> String {
    let (config, out) = (shell(config), shell(out));
    format!(
        "`{option}` is for sweeps whose points are all known beforehand: those of a space, but for its first set, are \
         chosen by what others told. Make the first set by shards, in one folder: umbrasim sweep {config} --shard I/N \
         --out {out}. Then the same without --shard goes on from it"
    )
}

/// The options that choose the level, as words of a shell, each after a space.
fn level_words(level: ChosenLevel) -> String {
    let fidelity = level.fidelity.map(|it| format!(" --fidelity {}", shell(Path::new(&it.to_string()))));
    let target = level.target_error.map(|it| format!(" --target-error {}", it.get()));
    fidelity.unwrap_or_default() + &target.unwrap_or_default()
}
