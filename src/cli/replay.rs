//! `replay`: a recorded ray stream on a machine.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::arguments::StreamAndMachine;
use super::destinations::claim_files;
use super::json_file::JsonFile;
use super::outcome::Outcome;
use super::print::print;
use super::replay_exports::{DramArgs, LineArgs};
use crate::experiment::dram_export::DramExport;
use crate::experiment::line_export::LineExport;
use crate::experiment::replay::replay_file;
use crate::replay::{Fidelity, Share};
use crate::report::run::replayed;
use crate::stream::StreamReader;

/// Replay a recorded ray stream on a machine and print the figures
#[derive(Args)]
pub(super) struct Replay {
    #[command(flatten)]
    input: StreamAndMachine,
    /// The fidelity level: Bound, Profile, Event, Cycle (plain, slow, the same numbers), Sampled(engine:
    /// Event, rate: 0.05), or Auto(error: 0.02)
    #[arg(long, value_name = "LEVEL", default_value_t)]
    fidelity: Fidelity,
    /// Sample, with more and more windows, until the intervals of cycles and of L2 and DRAM bytes are within this share
    /// [example: 1%]
    #[arg(long, value_name = "SHARE")]
    target_error: Option<Share>,
    /// Write all measurements to this file too, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    dram: DramArgs,
    #[command(flatten)]
    lines: LineArgs,
}

impl Replay {
    pub(super) fn run(self) -> Result<Outcome> {
        claim_files([("--json", self.json.as_deref())])?;
        self.dram.claim()?;
        self.lines.claim()?;
        let (stream, machine) = (&self.input.stream, self.input.machine()?);
        let fidelity = match self.target_error {
            Some(target) => self.fidelity.with_target_error(target).map_err(anyhow::Error::msg)?,
            None => self.fidelity,
        };
        let header = StreamReader::open(stream)?.header().clone();
        let json = JsonFile::begin(self.json)?;
        let (mut dram, mut lines) = (self.dram.begin(&machine)?, self.lines.begin(&machine, &header)?);
        let stats = replay_file(&machine, fidelity, stream, dram.as_mut(), lines.as_mut())?;
        dram.map_or(Ok(()), DramExport::finish)?;
        lines.map_or(Ok(()), LineExport::finish)?;
        json.finish(&stats)?;
        print(replayed(&machine.name, &header.policy, &stats))?;
        Ok(Outcome::Done)
    }
}
