//! The commands that a DRAM channel is given, and a log of them.

use crate::quantity::LineAddr;

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Opens a row of a bank.
    Activate {
        /// The bank.
        bank: usize,
        /// The row.
        row: u64,
    },
    /// Reads a burst of a bank's open row.
    Read(Column),
    /// Writes a burst of a bank's open row.
    Write(Column),
    /// Closes a bank's row.
    Precharge {
        /// The bank.
        bank: usize,
    },
    /// Closes all rows.
    PrechargeAll,
    /// Refreshes all banks.
    Refresh,
}

/// What a column command names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// The bank.
    pub bank: usize,
    /// The row.
    pub row: u64,
    /// The burst's place in the row.
    pub column: u64,
    /// Whether the bank closes the row afterwards by itself.
    pub auto_precharge: bool,
}

/// A command and the clock of the DRAM in which it was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoggedCommand {
    /// The clock.
    pub clock: u64,
    /// The command.
    pub command: Command,
}

/// A request and when it came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoggedRequest {
    /// The clock of the DRAM in which it came: commands for it can be given from the next one on.
    pub clock: u64,
    /// The line.
    pub line: LineAddr,
    /// Whether it is written.
    pub write: bool,
}

/// What a channel was asked for and which commands it was given, each in order, kept if somebody wants them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChannelLog {
    is_kept: bool,
    requests: Vec<LoggedRequest>,
    commands: Vec<LoggedCommand>,
}

impl ChannelLog {
    /// From now on all is kept.
    pub fn keep(&mut self) {
        self.is_kept = true;
    }

    /// Whether it is kept.
    pub fn is_kept(&self) -> bool {
        self.is_kept
    }

    /// A request came in clock `clock`.
    pub fn put(&mut self, clock: u64, line: LineAddr, write: bool) {
        if self.is_kept {
            self.requests.push(LoggedRequest { clock, line, write });
        }
    }

    /// `command` is given in clock `clock`.
    pub fn give(&mut self, clock: u64, command: Command) {
        if self.is_kept {
            self.commands.push(LoggedCommand { clock, command });
        }
    }

    /// The commands that were kept.
    pub fn commands(&self) -> &[LoggedCommand] {
        &self.commands
    }

    /// Takes out the requests and commands that were kept up to now.
    pub fn drain(&mut self) -> (impl Iterator<Item = LoggedRequest>, impl Iterator<Item = LoggedCommand>) {
        (self.requests.drain(..), self.commands.drain(..))
    }
}
