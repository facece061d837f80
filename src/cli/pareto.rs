//! `pareto`: error against speed of every fidelity level.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::arguments::report_folder;
use super::config_path::{config_path, or_other_kind};
use super::destinations::results_folder;
use super::ending::Ending;
use super::outcome::Outcome;
use crate::experiment::pareto;
use crate::fields::Root;
use crate::output::signals;
use crate::replay::Fidelity;
use crate::report;
use crate::report::pareto::ParetoReport;

/// Chart the error of each fidelity level against its speed
///
/// The same streams are replayed by every level. The report has a table (`pareto.csv`), a chart and a page: errors of
/// cycles, of L2 and DRAM bytes and of what policies save, mean and worst, beside what the levels claim; which level
/// none beats; and where one puts policies or machines in a wrong order.
#[derive(Args)]
pub(super) struct Pareto {
    /// The comparison: a file, or the name of a shipped one
    #[arg(default_value = "pareto")]
    config: PathBuf,
    /// What the levels are held to, in place of the file's: Event or Cycle
    #[arg(long, value_name = "LEVEL")]
    truth: Option<Fidelity>,
    /// Where the report goes [default: reports/, the name of the comparison's file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    ending: Ending,
}

impl Pareto {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        let out = results_folder(&report_folder(self.out, &self.config)?)?;
        let stop = signals::stop_flag();
        let config = config_path(Root::Pareto, &self.config)?;
        let found = pareto::pareto(&config, self.truth, &stop);
        let (summary, timings) = found.map_err(|error| or_other_kind(error, &config, Root::Pareto))?;
        let table = report::drawn(&summary.grid(&timings));
        let found = ParetoReport { summary, timings };
        let page = report::write(&out, &found)?;
        let verdict = found.summary.verdict(&found.timings);
        self.ending.tell(&found.summary, &table, &verdict, begin, Some(&page))?;
        Ok(Outcome::Done)
    }
}
