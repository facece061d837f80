//! `paper-table`: the published figures of GI09 beside ours.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::config_path::{config_path, or_other_kind};
use super::destinations::claim_files;
use super::ending::tell;
use super::json_file::JsonFile;
use super::outcome::Outcome;
use crate::experiment::paper;
use crate::fields::Root;
use crate::output::signals;
use crate::report;

/// Print the published figures of GI09 beside ours
///
/// Ours are given under every reading of the published text that the config lists.
#[derive(Args)]
pub(super) struct PaperTable {
    /// The table: a file, or the name of a shipped one
    #[arg(default_value = "paper_table")]
    config: PathBuf,
    /// Write all readings to this file too, as JSON
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    json: Option<PathBuf>,
}

impl PaperTable {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        claim_files([("--json", self.json.as_deref())])?;
        let json = JsonFile::begin(self.json)?;
        let stop = signals::stop_flag();
        let config = config_path(Root::PaperTable, &self.config)?;
        let readings = paper::paper_table(&config, &stop);
        let readings = readings.map_err(|error| or_other_kind(error, &config, Root::PaperTable))?;
        let is_alone = json.is_alone();
        json.finish(&readings)?;
        if !is_alone {
            tell(&report::drawn(&paper::grid(&readings)), &paper::verdict(&readings), begin)?;
        }
        Ok(Outcome::failed_if(stop.load(Ordering::Relaxed)))
    }
}
