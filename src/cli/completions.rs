//! `completions`: scripts that complete the command line in shells.

use anyhow::Result;
use clap::Args;
use clap_complete::{Shell, generate};

use super::outcome::Outcome;
use super::print::print;
use super::program;

/// Print a script that completes commands and options in a shell
///
/// For bash: umbrasim completions bash > ~/.local/share/bash-completion/completions/umbrasim
#[derive(Args)]
pub(super) struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    pub(super) fn run(self) -> Result<Outcome> {
        let mut cli = program::get();
        let mut script = Vec::new();
        generate(self.shell, &mut cli, "umbrasim", &mut script);
        print(String::from_utf8_lossy(&script).trim_end())?;
        Ok(Outcome::Done)
    }
}
