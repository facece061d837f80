//! `identities`: the T&I engine's published table beside ours.

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
use crate::experiment::{Setting, check_once, identities};
use crate::fields::Root;
use crate::output::signals;
use crate::report;

/// Replay rays of one kind on the T&I engine, beside its table
///
/// The rays are all primary, all shadow or all diffuse rays. Holds two identities that tie the table's columns:
/// utilisation is operations a ray times rays a second over the peak, and DRAM bytes a ray follow from operations and
/// hit rates. The command fails if the first does not hold.
#[derive(Args)]
pub(super) struct Identities {
    /// The table: a file, or the name of a shipped one
    #[arg(default_value = "identities")]
    config: PathBuf,
    /// Set a field of the table or of its machine; may be given again [example: traversal.count=48]
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Setting>,
    /// Write all rows to this file too, as JSON
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    json: Option<PathBuf>,
}

impl Identities {
    pub(super) fn run(self) -> Result<Outcome> {
        let (begin, stop) = (Instant::now(), signals::stop_flag());
        claim_files([("--json", self.json.as_deref())])?;
        let json = JsonFile::begin(self.json)?;
        let config = config_path(Root::Identities, &self.config)?;
        check_once(&self.set).map_err(anyhow::Error::msg)?;
        let table = identities::Table::load(&config, &self.set);
        let table = table.map_err(|error| or_other_kind(error, &config, Root::Identities))?;
        let (rows, published) = identities::identities(table, &stop)?;
        let is_alone = json.is_alone();
        json.finish(&rows)?;
        let worst = rows.iter().map(|row| row.utilization_gap).fold(0.0, f64::max);
        if !is_alone {
            let table = report::drawn(&identities::grid(&rows, &published));
            tell(&table, &format!("largest gap of utilisation: {:.3} points", 100.0 * worst), begin)?;
        }
        Ok(Outcome::failed_if(stop.load(Ordering::Relaxed) || worst > identities::MOST_GAP))
    }
}
