//! The commands that a DRAM channel is given, and a log of them.

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
    /// Reads a line of a bank's open row.
    Read {
        /// The bank.
        bank: usize,
        /// The row.
        row: u64,
    },
    /// Writes a line of a bank's open row.
    Write {
        /// The bank.
        bank: usize,
        /// The row.
        row: u64,
    },
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

/// A command and the cycle of the machine in which it was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoggedCommand {
    /// The cycle.
    pub cycle: u64,
    /// The command.
    pub command: Command,
}

/// The commands of a channel in order, kept if somebody wants them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CommandLog {
    commands: Option<Vec<LoggedCommand>>,
}

impl CommandLog {
    /// From now on all commands are kept.
    pub fn keep(&mut self) {
        self.commands.get_or_insert_default();
    }

    /// `command` is given in cycle `cycle`.
    pub fn give(&mut self, cycle: u64, command: Command) {
        if let Some(commands) = &mut self.commands {
            commands.push(LoggedCommand { cycle, command });
        }
    }

    /// What was kept.
    pub fn commands(&self) -> &[LoggedCommand] {
        self.commands.as_deref().unwrap_or_default()
    }
}
