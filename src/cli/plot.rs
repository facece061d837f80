//! `plot`: draws a report again.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::outcome::Outcome;
use super::print::print;
use crate::output::ResultsFolder;
use crate::report::run::redraw;

/// Draw a report's plots and page again, from its numbers on disk
#[derive(Args)]
pub(super) struct Plot {
    /// The report's folder
    report: PathBuf,
}

impl Plot {
    pub(super) fn run(self) -> Result<Outcome> {
        print(redraw(&ResultsFolder::claim(&self.report)?)?.display())?;
        Ok(Outcome::Done)
    }
}
