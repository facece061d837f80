//! `extrapolate`: a machine of many cores, from scale models of it with few.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, anyhow, ensure};
use clap::Args;

use super::arguments::StreamAndMachine;
use super::destinations::{claim_files, results_folder};
use super::ending::tell;
use super::json_file::JsonFile;
use super::outcome::Outcome;
use super::print::print;
use crate::experiment::extrapolate::{self, Task};
use crate::machine::MachineSpec;
use crate::replay::Fidelity;
use crate::report;
use crate::report::extrapolate::{self as tables, Extrapolations};

/// Predict a machine of many cores from scale models of few
///
/// What the machine takes for a recorded ray stream is told by models with few of its cores. A model of 2 of 16 cores
/// has two of the cores and an eighth of what all cores share, and replays an eighth of the pixels: it takes about as
/// long as the large machine. What is left of the difference shrinks with the model's cores, so that the line through
/// two models tells the large machine. Models of 2 and 4 of 16 cores replay 6 of 16 rays, those of 4 and 8 of 64 cores
/// 12 of 64.
#[derive(Args)]
pub(super) struct Extrapolate {
    #[command(flatten)]
    input: StreamAndMachine,
    /// Cores of the large machine; may be given several [default: as the machine's file has it; example: 16,64]
    #[arg(long, value_name = "CORES", value_delimiter = ',')]
    cores: Vec<u64>,
    /// DRAM channels of the large machine [default: as many for each core as the machine's file has]
    #[arg(long, value_name = "CHANNELS")]
    channels: Option<u64>,
    /// Cores of the scale models, two or more [default: 2,4; of 64 cores 4,8; of four cores or fewer 1,2]
    #[arg(long, value_name = "CORES", value_delimiter = ',')]
    models: Vec<u64>,
    /// The fidelity level that replays the models: Profile, Event or Cycle
    #[arg(long, value_name = "LEVEL", default_value_t)]
    fidelity: Fidelity,
    /// Replay the large machine by Event too, and say what the prediction is off
    #[arg(long)]
    check: bool,
    /// Write all numbers to this file too, as JSON; without a name, to standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    json: Option<PathBuf>,
    /// Write a report to this folder too: a page with the models and the law, and extrapolate.csv
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Extrapolate {
    pub(super) fn run(self) -> Result<Outcome> {
        claim_files([("--json", self.json.as_deref())])?;
        let out = self.out.as_deref().map(results_folder).transpose()?;
        let begin = Instant::now();
        let mut machines = Vec::new();
        for machine in self.input.machines()? {
            machines.extend(self.large(&machine)?);
        }
        let json = JsonFile::begin(self.json)?;
        let is_alone = json.is_alone();
        let mut found = Vec::new();
        for machine in &machines {
            let task = Task { machine, models: &self.models, fidelity: self.fidelity, checks: self.check };
            found.push(extrapolate::extrapolate(&task, &self.input.stream)?);
        }
        match found.as_slice() {
            [one] => json.finish(one)?,
            several => json.finish(&several)?,
        }
        let found = Extrapolations(found);
        let page = out.map(|out| report::write(&out, &found)).transpose()?;
        if !is_alone {
            let told = found.0.iter().map(|it| report::drawn(&tables::grid(it))).collect::<Vec<_>>().join("\n\n");
            let verdict = found.0.iter().map(tables::verdict).collect::<Vec<_>>().join("\n");
            tell(&told, &verdict, begin)?;
            page.map_or(Ok(()), |page| print(format!("report: {}", page.display())))?;
        }
        Ok(Outcome::Done)
    }

    /// The large machines derived from `machine`, one for each number of cores.
    fn large(&self, machine: &MachineSpec) -> Result<Vec<MachineSpec>> {
        let own = [machine.cores.get()];
        ensure!(
            own != [1] || !self.cores.is_empty(),
            "{} has 1 core: --cores says how many the large machine has",
            machine.name
        );
        let cores = if self.cores.is_empty() { &own[..] } else { &self.cores };
        let large = |&cores: &u64| {
            // If the machine is valid with one channel, the number of channels is what is wrong.
            let by_channels = self.channels.is_none() && machine.with_cores(cores, Some(1)).is_ok();
            let hint = if by_channels { " (--channels says how many)" } else { "" };
            machine.with_cores(cores, self.channels).map_err(|error| anyhow!("{error}{hint}"))
        };
        cores.iter().map(large).collect()
    }
}
