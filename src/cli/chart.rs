//! `chart`: saving against error over several runs.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::destinations::results_folder;
use super::ending::Ending;
use super::outcome::Outcome;
use crate::report;
use crate::report::chart::ChartSummary;
use crate::report::run::read_summary;

/// Chart what policies save against what they get wrong, over runs
///
/// The runs' reports give the numbers.
#[derive(Args)]
pub(super) struct Chart {
    /// Folders of reports, from `umbrasim run`
    #[arg(required = true, value_name = "REPORT_DIR")]
    reports: Vec<PathBuf>,
    /// Where the chart goes
    #[arg(long, value_name = "DIR", default_value = "reports/chart")]
    out: PathBuf,
    #[command(flatten)]
    ending: Ending,
}

impl Chart {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        let out = results_folder(&self.out)?;
        let read = |report: PathBuf| read_summary(&report.join(report::SUMMARY_FILE));
        let runs = self.reports.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let chart = ChartSummary::new(&runs);
        let page = report::write(&out, &chart)?;
        self.ending.tell(&chart, &report::drawn(&chart.grid()), &report::chart::finding(&chart), begin, Some(&page))?;
        Ok(Outcome::Done)
    }
}
