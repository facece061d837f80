//! `diff`: two reports beside each other.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::outcome::Outcome;
use super::print::print;
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
}

impl Diff {
    pub(super) fn run(self) -> Result<Outcome> {
        let found = Differences::of([&self.a, &self.b], self.all)?;
        let grids = [found.config_grid(), found.figures_grid()];
        for grid in grids.iter().filter(|grid| !grid.rows.is_empty()) {
            print(format!("{}\n", report::drawn(grid)))?;
        }
        print(format!("A: {}, B: {}", self.a.display(), self.b.display()))?;
        print(format!(
            "{} and {} of {} figures differ",
            match found.config.len() {
                0 => "no field of the configuration".to_owned(),
                1 => "1 field of the configuration".to_owned(),
                count => format!("{count} fields of the configuration"),
            },
            found.differing(),
            found.compared()
        ))?;
        Ok(Outcome::Done)
    }
}
