//! The `umbrasim` program: parses the command line, runs the command, prints errors.

mod cli;

use std::process::ExitCode;

use anyhow::Context;
use clap::Parser;
use umbrasim::engine::RunError;
use umbrasim::experiment::run::RunFailure;
use umbrasim::experiment::sweep::SweepError;
use umbrasim::experiment::trace::TraceError;
use umbrasim::stream::StreamError;

fn main() -> ExitCode {
    #[cfg(unix)]
    outlive_size_limits();
    let done = umbrasim::output::signals::watch().context("cannot watch for signals");
    match done.and_then(|()| cli::execute(cli::Cli::parse())) {
        Ok(status) => ExitCode::from(status),
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(status(&error))
        }
    }
}

/// Makes a write beyond a file size limit an error, as one to a full disk is; else a signal would end the program without
/// a word and leave its temporary files behind.
#[cfg(unix)]
fn outlive_size_limits() {
    use nix::sys::signal::{SigSet, Signal};
    let mut blocked = SigSet::empty();
    blocked.add(Signal::SIGXFSZ);
    // Threads started later inherit this. Without it the program still works, but for that message.
    let _ = blocked.thread_block();
}

/// 1 for what was stopped or went wrong inside a simulation, 2 for what the user can mend.
fn status(error: &anyhow::Error) -> u8 {
    let replay_failed = error.downcast_ref::<RunError<StreamError>>().is_some_and(|error| {
        matches!(
            error,
            RunError::Counts { .. } | RunError::Invariant(_) | RunError::Illegal { .. } | RunError::Deadlock { .. }
        )
    });
    let stopped = matches!(error.downcast_ref(), Some(TraceError::Stopped))
        || matches!(error.downcast_ref(), Some(SweepError::Stopped | SweepError::Machine { .. }));
    if replay_failed || stopped || error.is::<RunFailure>() { 1 } else { 2 }
}
