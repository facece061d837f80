//! `explain`: what the numbers of a report mean.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::outcome::Outcome;
use super::print::print;
use crate::report;

/// Say what the numbers of a report mean: unit and definition
///
/// With a report, their values in it are printed too.
#[derive(Args)]
pub(super) struct Explain {
    /// The end of a statistic's path, such as row_hits or bytes.dram.node [default: all statistics]
    name: Option<String>,
    /// A report's folder, to show the values in it
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

impl Explain {
    pub(super) fn run(self) -> Result<Outcome> {
        let read = |report: PathBuf| report::read_numbers(&report.join(report::SUMMARY_FILE));
        let numbers = self.report.map(read).transpose()?;
        let text = report::explain::explain(self.name.as_deref(), numbers.as_ref()).map_err(anyhow::Error::msg)?;
        print(text)?;
        Ok(Outcome::Done)
    }
}
