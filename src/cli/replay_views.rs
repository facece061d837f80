//! Files of `replay` that show a run over time.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::destinations::claim_files;
use crate::experiment::interval_export::IntervalExport;
use crate::experiment::timeline::Timeline;
use crate::machine::MachineSpec;
use crate::stream::Header;

/// What units did in each cycle, and what was counted from time to time.
#[derive(Args)]
#[command(next_help_heading = "Over time")]
pub(super) struct ViewArgs {
    /// Write a frame's timeline to this file, to be opened at ui.perfetto.dev; Event and Cycle only
    ///
    /// The file has Perfetto's TrackEvent form. A track a unit shows the cause of each of its cycles; others show
    /// depths of queues, misses under way, and open rows of the DRAM's banks. A nanosecond there is a cycle.
    #[arg(long, value_name = "FILE")]
    timeline: Option<PathBuf>,
    /// The timeline's frame [default: the first one that is measured]
    #[arg(long, value_name = "FRAME", requires = "timeline")]
    timeline_frame: Option<u32>,
    /// Write counters of every N cycles, as CSV; Event and Cycle only
    ///
    /// The columns are those of a machine in `frames.csv`. The last interval of a frame ends with it, so that the rows
    /// of a frame sum to its counters.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    interval: Option<u64>,
    /// Where these counters go; `-` is standard output
    #[arg(long, value_name = "FILE", default_value = "-", requires = "interval")]
    interval_out: PathBuf,
}

impl ViewArgs {
    /// Whether a file is wanted.
    pub(super) fn is_wanted(&self) -> bool {
        self.timeline.is_some() || self.interval.is_some()
    }

    /// Claims the files that are wanted.
    pub(super) fn claim(&self) -> Result<()> {
        let interval_out = self.interval.map(|_| self.interval_out.as_path());
        claim_files([("--timeline", self.timeline.as_deref()), ("--interval-out", interval_out)])
    }

    /// Begins the timeline, if it is wanted.
    pub(super) fn timeline(&self, machine: &MachineSpec, header: &Header) -> Result<Option<Timeline>> {
        let begin = |path: &PathBuf| Timeline::create(machine, header, self.timeline_frame, path);
        Ok(self.timeline.as_ref().map(begin).transpose()?)
    }

    /// Begins the counters, if they are wanted.
    pub(super) fn interval(&self, header: &Header) -> Result<Option<IntervalExport>> {
        let begin = |interval| IntervalExport::create(header, interval, &self.interval_out);
        Ok(self.interval.map(begin).transpose()?)
    }
}
