//! `stress`: every policy on every scene that is known to break one.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::destinations::results_folder;
use super::ending::Ending;
use super::outcome::Outcome;
use crate::console;
use crate::experiment::stress;
use crate::report;

/// Run every policy on every small scene known to break one
///
/// Beside the map, the report shows how far other answers to what the published text leaves open move saving and
/// error. The command fails if a policy that must never be wrong is.
#[derive(Args)]
pub(super) struct Stress {
    /// These cases alone [example: C1,C8,Slivers]; what the text leaves open is not looked at then
    #[arg(long = "case", value_name = "CASE", value_delimiter = ',')]
    cases: Vec<String>,
    /// Where the report goes
    #[arg(long, value_name = "DIR", default_value = "reports/stress")]
    out: PathBuf,
    #[command(flatten)]
    ending: Ending,
}

impl Stress {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        let out = results_folder(&self.out)?;
        let cases = stress::cases(&self.cases).map_err(anyhow::Error::msg)?;
        let summary = stress::run(&cases, self.cases.is_empty());
        let page = report::write(&out, &summary)?;
        let broken = summary.broken();
        broken.iter().for_each(|broken| console::tell(format_args!("wrong, and must never be: {broken}")));
        self.ending.tell(&summary, "", &summary.verdict(), begin, Some(&page))?;
        Ok(Outcome::failed_if(!broken.is_empty()))
    }
}
