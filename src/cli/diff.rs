//! `diff`: two reports beside each other.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::destinations::results_folder;
use super::ending::Ending;
use super::outcome::Outcome;
use crate::report;
use crate::report::diff::Diff as Differences;

/// Compare two reports: what was set, and what was found
///
/// Tells fields of the experiments as run that differ, and key figures that differ, with the change from A to B in
/// percent.
#[derive(Args)]
pub(super) struct Diff {
    /// The folder of the report that is compared with
    a: PathBuf,
    /// The folder of the report that is compared
    b: PathBuf,
    /// All numbers of the reports, not the key figures alone
    #[arg(long)]
    all: bool,
    /// Write a report of the comparison: tables, a plot and a page
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    ending: Ending,
}

impl Diff {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        let out = self.out.as_deref().map(results_folder).transpose()?;
        let found = Differences::of([&self.a, &self.b], self.all)?;
        let key = format!("A: {}, B: {}", self.a.display(), self.b.display());
        let parts = found.grids().map(|grid| report::drawn(&grid)).chain([key]);
        let tables = parts.collect::<Vec<_>>().join("\n\n");
        let page = out.map(|out| report::write(&out, &found)).transpose()?;
        self.ending.tell(&found, &tables, &found.verdict(), begin, page.as_deref())?;
        Ok(Outcome::Done)
    }
}
