//! `ladder-map`: where each fidelity level breaks.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::destinations::results_folder;
use super::ending::Ending;
use super::outcome::Outcome;
use crate::experiment::ladder_map::{self, Effort};
use crate::report;

/// Map where each fidelity level breaks, on synthetic streams
///
/// The streams are swept over what the levels assume: length, updates that one unit takes, the pool, skew, footprint,
/// coherence, caches, rays in flight, miss registers and bursts: how far each level is from Event, as a table of the
/// worst, `ladder.csv` and a heat map.
#[derive(Args)]
pub(super) struct LadderMap {
    /// Where the map goes
    #[arg(long, value_name = "DIR", default_value = "reports/ladder_map")]
    out: PathBuf,
    /// Every other point, on streams an eighth as long: less than a minute
    #[arg(long)]
    quick: bool,
    /// These axes alone, by how their names begin; may be given again [example: skew]
    #[arg(long, value_name = "NAME")]
    axis: Vec<String>,
    #[command(flatten)]
    ending: Ending,
}

impl LadderMap {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        let out = results_folder(&self.out)?;
        let map = ladder_map::run(if self.quick { Effort::Quick } else { Effort::Full }, &self.axis)?;
        let plot = report::write(&out, &map)?;
        let table = report::drawn(&report::ladder_map::grid(&map));
        self.ending.tell(&map, &table, &report::ladder_map::verdict(&map), begin, Some(&plot))?;
        Ok(Outcome::Done)
    }
}
