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

    /// `command` is given in clock `clock`.
    pub fn give(&mut self, clock: u64, command: Command) {
        if let Some(commands) = &mut self.commands {
            commands.push(LoggedCommand { clock, command });
        }
    }

    /// What was kept.
    pub fn commands(&self) -> &[LoggedCommand] {
        self.commands.as_deref().unwrap_or_default()
    }
}
