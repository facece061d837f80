//! Files that `replay` writes for other simulators.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::destinations::claim_files;
use crate::experiment::dram_export::{DramExport, TraceFormat};
use crate::experiment::line_export::LineExport;
use crate::machine::MachineSpec;
use crate::stream::Header;

/// What the DRAM was asked for and what it did.
#[derive(Args)]
#[command(next_help_heading = "DRAM")]
pub(super) struct DramArgs {
    /// Write the requests that came to the DRAM to this file, for another DRAM simulator; Event and Cycle only
    ///
    /// A line a burst of the DRAM's part, with the byte address that the machine's `dram.mapping` takes apart, and the
    /// clock of the DRAM in which the request came.
    #[arg(long, value_name = "FILE")]
    dram_trace: Option<PathBuf>,
    /// Who is to read it
    #[arg(long, value_name = "SIMULATOR", default_value = "dramsim3", requires = "dram_trace")]
    dram_trace_format: TraceFormat,
    /// Write the commands that the DRAM was given to this file, as CSV; Event and Cycle only
    ///
    /// Clocks are the DRAM's. A column is a burst's place in its row; the command RDA or WRA closes the row by itself,
    /// PREA closes all rows. Ranks are not modelled. All commands are checked against the timing of the DRAM's part by
    /// code of its own, and a violation is an error.
    #[arg(long, value_name = "FILE")]
    dram_commands: Option<PathBuf>,
}

impl DramArgs {
    /// Claims the files that are wanted.
    pub(super) fn claim(&self) -> Result<()> {
        claim_files([("--dram-trace", self.dram_trace.as_deref()), ("--dram-commands", self.dram_commands.as_deref())])
    }

    /// Whether a file is wanted.
    pub(super) fn is_wanted(&self) -> bool {
        self.dram_trace.is_some() || self.dram_commands.is_some()
    }

    /// Begins the files that are wanted.
    pub(super) fn begin(&self, machine: &MachineSpec) -> Result<Option<DramExport>> {
        if !self.is_wanted() {
            return Ok(None);
        }
        let trace = self.dram_trace.as_deref().map(|path| (self.dram_trace_format, path));
        Ok(Some(DramExport::create(machine, trace, self.dram_commands.as_deref())?))
    }
}

/// What a kind of L1 was asked for.
#[derive(Args)]
#[command(next_help_heading = "Caches")]
pub(super) struct LineArgs {
    /// Write the lines that a kind of L1 is asked for to this file, for a cache simulator
    ///
    /// In Dinero's form (`0 ADDRESS` reads, `1 ADDRESS` writes, hexadecimal), in the order of the stream: what one such
    /// cache would see if each ray were done before the next one began. It depends on the machine's memory layout, not
    /// on its caches.
    #[arg(long, value_name = "FILE")]
    line_trace: Option<PathBuf>,
    /// Which L1s: l1_traversal, l1_list, l1_intersection or l1_shadow_cache
    #[arg(long, value_name = "NAME", default_value = "l1_traversal", requires = "line_trace")]
    line_trace_cache: String,
}

impl LineArgs {
    /// Claims the file that is wanted.
    pub(super) fn claim(&self) -> Result<()> {
        claim_files([("--line-trace", self.line_trace.as_deref())])
    }

    /// Whether a file is wanted.
    pub(super) fn is_wanted(&self) -> bool {
        self.line_trace.is_some()
    }

    /// Begins the file that is wanted.
    pub(super) fn begin(&self, machine: &MachineSpec, header: &Header) -> Result<Option<LineExport>> {
        let begin = |path: &PathBuf| LineExport::create(machine, header, &self.line_trace_cache, path);
        Ok(self.line_trace.as_ref().map(begin).transpose()?)
    }
}
