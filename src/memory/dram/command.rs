//! The commands of a DRAM channel, and a log of them.

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

/// The operands of a column command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// The bank.
    pub bank: usize,
    /// The row.
    pub row: u64,
    /// Index of the burst in the row.
    pub column: u64,
    /// Whether the bank closes the row by itself afterwards.
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

/// A request and its arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoggedRequest {
    /// The clock of the DRAM in which it arrived; its commands can be given from the next clock on.
    pub clock: u64,
    /// The line.
    pub line: LineAddr,
    /// Whether it is written.
    pub write: bool,
}

/// Requests to a channel and commands given to it, each in order. Logging is off by default.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChannelLog {
    is_kept: bool,
    requests: Vec<LoggedRequest>,
    commands: Vec<LoggedCommand>,
}

impl ChannelLog {
    /// Turns logging on.
    pub fn keep(&mut self) {
        self.is_kept = true;
    }

    /// Whether logging is on.
    pub fn is_kept(&self) -> bool {
        self.is_kept
    }

    /// Logs a request that arrives in clock `clock`.
    pub fn put(&mut self, clock: u64, line: LineAddr, write: bool) {
        if self.is_kept {
            self.requests.push(LoggedRequest { clock, line, write });
        }
    }

    /// Logs `command`, given in clock `clock`.
    pub fn give(&mut self, clock: u64, command: Command) {
        if self.is_kept {
            self.commands.push(LoggedCommand { clock, command });
        }
    }

    /// The logged commands.
    pub fn commands(&self) -> &[LoggedCommand] {
        &self.commands
    }

    /// Removes and returns the requests and commands logged so far.
    pub fn drain(&mut self) -> (impl Iterator<Item = LoggedRequest>, impl Iterator<Item = LoggedCommand>) {
        (self.requests.drain(..), self.commands.drain(..))
    }
}
