//! Writes the DRAM requests of a replay for other DRAM simulators, and the commands of its own DRAM.

use std::io;
use std::path::Path;

use clap::ValueEnum;

use super::export_file::ExportFile;
use crate::machine::MachineSpec;
use crate::memory::dram::command::{Column, Command, LoggedCommand, LoggedRequest};
use crate::memory::dram::part::DramPart;
use crate::replay::Observer;

/// Who is to read a trace of requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TraceFormat {
    /// `0xADDRESS READ|WRITE CLOCK`, which DRAMsim3 takes with `-t`.
    Dramsim3,
    /// `LD|ST 0xADDRESS`, which Ramulator 2's `LoadStoreTrace` takes: without clocks, in order.
    Ramulator,
}

/// Writes the requests of a run, its DRAM's commands, or both, during the run.
pub(crate) struct DramExport {
    trace: Option<(TraceFormat, ExportFile)>,
    commands: Option<ExportFile>,
    part: DramPart,
    line: u64,
}

impl DramExport {
    /// Begins the files.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn create(
        machine: &MachineSpec,
        trace: Option<(TraceFormat, &Path)>,
        commands: Option<&Path>,
    ) -> io::Result<Self> {
        let trace = trace.map(|(format, path)| Ok::<_, io::Error>((format, ExportFile::create(path)?))).transpose()?;
        let mut commands = commands.map(ExportFile::create).transpose()?;
        if let Some(file) = &mut commands {
            file.line(format_args!("clock,channel,command,bank_group,bank,row,column"))?;
        }
        Ok(Self { trace, commands, part: machine.dram.part.clone(), line: machine.line_bytes.get() })
    }

    /// Puts the files into their places.
    pub(crate) fn finish(self) -> io::Result<()> {
        self.trace.map_or(Ok(()), |(_, file)| file.finish())?;
        self.commands.map_or(Ok(()), ExportFile::finish)
    }
}

impl Observer for DramExport {
    fn wants_dram(&self) -> bool {
        true
    }

    /// Writes a line per burst: the readers' requests are bursts.
    fn request(&mut self, _: usize, LoggedRequest { clock, line, write }: LoggedRequest) -> io::Result<()> {
        let Some((format, file)) = &mut self.trace else { return Ok(()) };
        for burst in 0..self.part.bursts(self.line) {
            let address = line.0 * self.line + burst * self.part.burst_bytes.get();
            match format {
                TraceFormat::Dramsim3 => {
                    file.line(format_args!("{address:#x} {} {clock}", if write { "WRITE" } else { "READ" }))?;
                }
                TraceFormat::Ramulator => {
                    file.line(format_args!("{} {address:#x}", if write { "ST" } else { "LD" }))?
                }
            }
        }
        Ok(())
    }

    fn command(&mut self, channel: usize, LoggedCommand { clock, command }: LoggedCommand) -> io::Result<()> {
        let Some(file) = &mut self.commands else { return Ok(()) };
        let in_group = self.part.banks.size() / self.part.bank_groups.size();
        let place = |bank: usize| format!("{},{}", bank / in_group, bank % in_group);
        let named = |plain, closing, at: Column| {
            let name = if at.auto_precharge { closing } else { plain };
            (name, format!("{},{},{}", place(at.bank), at.row, at.column))
        };
        let (name, place) = match command {
            Command::Activate { bank, row } => ("ACT", format!("{},{row},", place(bank))),
            Command::Read(at) => named("RD", "RDA", at),
            Command::Write(at) => named("WR", "WRA", at),
            Command::Precharge { bank } => ("PRE", format!("{},,", place(bank))),
            Command::PrechargeAll => ("PREA", ",,,".into()),
            Command::Refresh => ("REF", ",,,".into()),
        };
        file.line(format_args!("{clock},{channel},{name},{place}"))
    }
}
