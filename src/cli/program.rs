//! The whole command line as a value, for the commands that show it.

use std::sync::OnceLock;

use clap::Command;

static PROGRAM: OnceLock<Command> = OnceLock::new();

/// Sets the command line, once, before any command runs, and returns it.
pub(super) fn set(program: Command) -> Command {
    PROGRAM.get_or_init(|| program).clone()
}

/// The command line that was set.
pub(super) fn get() -> Command {
    PROGRAM.get().cloned().unwrap_or_default()
}
