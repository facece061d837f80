//! `inspect`: what a recorded ray stream holds.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::outcome::Outcome;
use super::print::print;
use crate::json;
use crate::stream::StreamReader;
use crate::stream::inspect::{inspect, render};

/// Say what a recorded ray stream holds
#[derive(Args)]
pub(super) struct Inspect {
    /// The stream's file
    stream: PathBuf,
    /// As JSON
    #[arg(long)]
    json: bool,
}

impl Inspect {
    pub(super) fn run(self) -> Result<Outcome> {
        let inspection = inspect(&mut StreamReader::open(&self.stream)?)?;
        let text = if self.json { json::pretty(&inspection)? } else { render(&inspection) };
        print(text)?;
        Ok(Outcome::Done)
    }
}
