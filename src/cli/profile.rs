//! `profile`: reuse distances of a recorded ray stream.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use super::arguments::StreamAndMachine;
use super::destinations::results_folder;
use super::ending::Ending;
use super::outcome::Outcome;
use crate::experiment::reuse::reuse;
use crate::replay::{ReuseOf, Share};
use crate::report;

/// Measure how a recorded ray stream misses in caches of all sizes
///
/// One pass replays the stream as the fidelity Profile does. The requests to each cache of the machine give reuse
/// distances, and these the misses of LRU caches of 1 KiB to 16 MiB in its place, by class of traffic: a table,
/// `reuse.csv` and a plot.
#[derive(Args)]
pub(super) struct Profile {
    #[command(flatten)]
    input: StreamAndMachine,
    /// Measure a share of the lines only, chosen by a hash [example: 0.01]
    #[arg(long, value_name = "SHARE")]
    sample: Option<Share>,
    /// With a sample: lines that are always in it, those that are asked for most often
    #[arg(long, value_name = "LINES", default_value_t = 4096, requires = "sample")]
    hot: usize,
    /// Where the report goes
    #[arg(long, value_name = "DIR", default_value = "reports/profile")]
    out: PathBuf,
    #[command(flatten)]
    ending: Ending,
}

impl Profile {
    pub(super) fn run(self) -> Result<Outcome> {
        let begin = Instant::now();
        let out = results_folder(&self.out)?;
        let machine = self.input.machine("a profile")?;
        let of = self.sample.map_or(ReuseOf::Everything, |rate| ReuseOf::Sample { rate, hot: self.hot });
        let summary = reuse(&machine, of, &self.input.stream)?;
        let plot = report::write(&out, &summary)?;
        let table = report::drawn(&report::reuse::grid(&summary));
        self.ending.tell(&summary, &table, &report::reuse::finding(&summary.levels), begin, Some(&plot))?;
        Ok(Outcome::Done)
    }
}
