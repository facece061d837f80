//! The command line. A command is a struct of arguments with `run`, in a file of its own; `command` lists them in the
//! groups that `--help` shows.

mod arguments;
#[cfg(test)]
mod book;
mod chart;
mod check;
mod command;
mod completions;
mod config_path;
mod describe;
mod destinations;
mod diff;
mod ending;
mod explain;
mod extrapolate;
mod help;
mod identities;
mod inspect;
mod json_file;
mod ladder_map;
mod man;
mod new;
mod outcome;
mod paper_table;
mod pareto;
mod plot;
mod print;
mod profile;
mod program;
mod replay;
mod replay_exports;
mod replay_views;
mod run;
mod schema;
mod stress;
mod sweep;
mod text_file;
mod trace;
mod validate;

use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{CommandFactory, FromArgMatches, Parser};

use command::{Command, Study};
use outcome::Outcome;

use crate::console;
use crate::output::signals;

/// Simulator of a fixed-function ray-tracing accelerator that culls shadow rays with mode words kept per primitive.
#[derive(Parser)]
#[command(version, max_term_width = 100, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Threads that trace, validate and replay samples; results don't depend on it [default: one a core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Say nothing but errors and where the result lies
    #[arg(long, global = true)]
    quiet: bool,
}

const AFTER_HELP: &str = "\
Start with:  umbrasim run quickstart
then open    reports/quickstart/index.html

Exit status: 0 done; 1 stopped by Ctrl-C, or a simulation failed; 2 a wrong command line, config, scene or stream.";

/// The `umbrasim` program: parses the command line, runs the command, and prints errors to standard error.
pub fn main() -> ExitCode {
    #[cfg(unix)]
    outlive_size_limits();
    let matches = program::set(help::grouped(Cli::command())).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let done = signals::watch().context("cannot watch for signals");
    match done.and_then(|()| execute(cli)) {
        Ok(outcome) => outcome.into(),
        Err(error) => {
            console::tell(format_args!("error: {error:#}"));
            outcome::exit_code(&error)
        }
    }
}

fn execute(mut cli: Cli) -> Result<Outcome> {
    if cli.quiet {
        console::be_quiet();
    }
    if let Some(threads) = cli.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
        pool.build_global().context("cannot start the threads")?;
    }
    if let Command::Study(Study::Sweep(sweep)) = &mut cli.command {
        sweep.threads = cli.threads;
    }
    cli.command.run()
}

/// Turns a write beyond a file size limit into an error, like a write to a full disk. Otherwise a signal ends the
/// program without a message, and its temporary files stay behind.
#[cfg(unix)]
fn outlive_size_limits() {
    use nix::sys::signal::{SigSet, Signal};
    let mut blocked = SigSet::empty();
    blocked.add(Signal::SIGXFSZ);
    // Threads started later inherit the mask. If this call fails, the program still works, but lacks that message.
    let _ = blocked.thread_block();
}
