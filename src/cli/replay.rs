//! `replay`: a recorded ray stream on a machine.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, ensure};
use clap::Args;

use super::arguments::StreamAndMachine;
use super::destinations::{claim_files, results_folder};
use super::ending::tell;
use super::json_file::JsonFile;
use super::outcome::Outcome;
use super::print::print;
use super::replay_exports::{DramArgs, LineArgs};
use super::replay_views::ViewArgs;
use crate::experiment::exports::Exports;
use crate::experiment::line_export::LineExport;
use crate::experiment::replay::replay_file;
use crate::named::Named;
use crate::replay::{Fidelity, Share};
use crate::report;
use crate::report::replay::ReplaySummary;
use crate::report::run::{replay_verdict, replayed};
use crate::stream::StreamReader;

/// Replay a recorded ray stream on machines and print the figures
#[derive(Args)]
pub(super) struct Replay {
    #[command(flatten)]
    input: StreamAndMachine,
    /// The fidelity level: Bound, Profile, Event, Cycle (plain, slow, the same numbers), Sampled(engine:
    /// Event, rate: 0.05), or Auto(error: 0.02)
    #[arg(long, value_name = "LEVEL", default_value_t)]
    fidelity: Fidelity,
    /// Sample, with more and more windows, until the 95 % intervals of cycles and of L2 and DRAM bytes are within this
    /// share [example: 1%]
    #[arg(long, value_name = "SHARE")]
    target_error: Option<Share>,
    /// Write all measurements to this file too, as JSON; without a name, to standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    json: Option<PathBuf>,
    /// Write all measurements to this folder too, in long form: results.csv, and what its columns and metrics mean
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    dram: DramArgs,
    #[command(flatten)]
    lines: LineArgs,
    #[command(flatten)]
    views: ViewArgs,
}

impl Replay {
    pub(super) fn run(self) -> Result<Outcome> {
        claim_files([("--json", self.json.as_deref())])?;
        let out = self.out.as_deref().map(results_folder).transpose()?;
        self.dram.claim()?;
        self.lines.claim()?;
        self.views.claim()?;
        let (begin, stream) = (Instant::now(), &self.input.stream);
        let machines = self.input.machines()?;
        let is_exported = self.dram.is_wanted() || self.lines.is_wanted() || self.views.is_wanted();
        ensure!(
            machines.len() == 1 || !is_exported,
            "a trace or a timeline is of one machine: {} are given",
            machines.len()
        );
        let fidelity = match self.target_error {
            Some(target) => self.fidelity.with_target_error(target).map_err(anyhow::Error::msg)?,
            None => self.fidelity,
        };
        let header = StreamReader::open(stream)?.header().clone();
        let json = JsonFile::begin(self.json)?;
        let is_alone = json.is_alone();
        let (mut found, mut told) = (Named::default(), Vec::new());
        for machine in &machines {
            let mut lines = self.lines.begin(machine, &header)?;
            let mut exports = Exports {
                dram: self.dram.begin(machine)?,
                timeline: self.views.timeline(machine, &header)?,
                interval: self.views.interval(&header)?,
            };
            let stats = replay_file(machine, fidelity, stream, &mut exports, lines.as_mut())?;
            told.extend(exports.finish()?);
            lines.map_or(Ok(()), LineExport::finish)?;
            found.insert(machine.name.clone(), stats);
        }
        if let Some(out) = &out {
            let summary = ReplaySummary::new(&header.scene, &header.policy, &fidelity.to_string(), &found);
            report::write(out, &summary)?;
        }
        match found.iter().next() {
            Some((_, stats)) if machines.len() == 1 => json.finish(stats)?,
            _ => json.finish(&found)?,
        }
        if !is_alone {
            let tables = [replayed(&fidelity.to_string(), &header.policy, &found)].into_iter().chain(told);
            tell(&tables.collect::<Vec<_>>().join("\n\n"), &replay_verdict(&found), begin)?;
            if let Some(out) = &self.out {
                print(format!("results: {}", out.join("results.csv").display()))?;
            }
        }
        Ok(Outcome::Done)
    }
}
