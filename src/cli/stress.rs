//! `stress`: every policy on every scene that is known to break one.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::destinations::results_folder;
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::stress;
use crate::report;

/// Run every policy on every small scene known to break one
///
/// Beside the map, the report shows how far other answers to what the published text leaves open move saving and
/// error. The command fails if a policy that must never be wrong is.
#[derive(Args)]
pub(super) struct Stress {
    /// Where the report goes
    #[arg(long, value_name = "DIR", default_value = "reports/stress")]
    out: PathBuf,
}

impl Stress {
    pub(super) fn run(self) -> Result<Outcome> {
        let out = results_folder(&self.out)?;
        let summary = stress::run();
        let page = report::write(&out, &summary)?;
        let broken = summary.broken();
        broken.iter().for_each(|broken| eprintln!("wrong, and must never be: {broken}"));
        print(page.display())?;
        Ok(Outcome::failed_if(!broken.is_empty()))
    }
}
