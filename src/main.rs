//! The `umbrasim` program: parses the command line, runs the command, prints errors.

mod cli;

use std::process::ExitCode;

use clap::Parser;
use umbrasim::engine::RunError;
use umbrasim::experiment::run::RunFailure;
use umbrasim::stream::StreamError;

fn main() -> ExitCode {
    match cli::execute(cli::Cli::parse()) {
        Ok(status) => ExitCode::from(status),
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(status(&error))
        }
    }
}

/// 1 for what went wrong inside a simulation, 2 for what the user can mend.
fn status(error: &anyhow::Error) -> u8 {
    let replay_failed = error.downcast_ref::<RunError<StreamError>>().is_some_and(|error| {
        matches!(error, RunError::Counts { .. } | RunError::Invariant(_) | RunError::Deadlock { .. })
    });
    if replay_failed || error.is::<RunFailure>() { 1 } else { 2 }
}
