//! `man`: manual pages.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use clap_mangen::Man as Page;

use super::outcome::Outcome;
use super::print::print;
use super::program;
use super::text_file::write;

/// Print the manual page, or write all pages to a folder
///
/// To look at it: umbrasim man | man -l -
#[derive(Args)]
pub(super) struct Man {
    /// Write a page for the program and one for each command to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Man {
    pub(super) fn run(self) -> Result<Outcome> {
        let mut cli = program::get();
        cli.build();
        let Some(folder) = self.out else {
            print(page(cli)?.trim_end())?;
            return Ok(Outcome::Done);
        };
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let commands: Vec<_> = cli.get_subcommands().filter(|it| it.get_name() != "help").cloned().collect();
        for command in commands.into_iter().chain([cli]) {
            let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
            write(&folder.join(format!("{name}.1")), &page(command)?)?;
        }
        print(folder.display())?;
        Ok(Outcome::Done)
    }
}

fn page(command: clap::Command) -> Result<String> {
    let mut page = Vec::new();
    Page::new(command).render(&mut page).context("cannot make the manual page")?;
    Ok(String::from_utf8_lossy(&page).into_owned())
}
