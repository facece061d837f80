//! `paper-table`: the published figures of GI09 beside ours.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use anyhow::Result;
use clap::Args;

use super::destinations::claim_files;
use super::json_file::JsonFile;
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::paper;
use crate::output::signals;
use crate::report;

/// Print the published figures of GI09 beside ours
///
/// Ours are given under every reading of the published text that the config lists.
#[derive(Args)]
pub(super) struct PaperTable {
    /// The table's file
    #[arg(default_value = "configs/experiments/paper_table.ron")]
    config: PathBuf,
    /// Write all readings to this file too, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl PaperTable {
    pub(super) fn run(self) -> Result<Outcome> {
        claim_files([("--json", self.json.as_deref())])?;
        let json = JsonFile::begin(self.json)?;
        let stop = signals::stop_flag();
        let readings = paper::paper_table(&self.config, &stop)?;
        json.finish(&readings)?;
        print(report::drawn(&paper::grid(&readings)))?;
        print("\ndistance: root mean square of the differences of the four shares, in points")?;
        Ok(Outcome::failed_if(stop.load(Ordering::Relaxed)))
    }
}
