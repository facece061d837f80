//! The end of a command: prints what it found, its time, and the path of its report.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Args;
use serde::Serialize;

use super::print::print;
use crate::console;
use crate::json;
use crate::report::paragraph;

/// How a command tells what it found.
#[derive(Args)]
pub(super) struct Ending {
    /// Print the numbers as JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

impl Ending {
    /// Prints what was found: `summary` as JSON with `--json`; otherwise tables, a verdict, the time since `begin` and
    /// the path of `page`. With `--quiet`, only the path.
    pub(super) fn tell(
        &self,
        summary: &impl Serialize,
        tables: &str,
        verdict: &str,
        begin: Instant,
        page: Option<&Path>,
    ) -> Result<()> {
        if self.json {
            return print(json::pretty(summary)?);
        }
        if console::is_quiet() {
            return page.map_or(Ok(()), |page| print(page.display()));
        }
        tell(tables, verdict, begin)?;
        page.map_or(Ok(()), |page| print(format!("report: {}", page.display())))
    }
}

/// Prints tables, a verdict and the time since `begin`; with `--quiet`, nothing.
pub(super) fn tell(tables: &str, verdict: &str, begin: Instant) -> Result<()> {
    if !console::is_quiet() {
        let verdict = verdict.lines().map(paragraph).collect::<Vec<_>>().join("\n");
        let parts = [tables, &verdict].into_iter().filter(|part| !part.is_empty());
        print(parts.collect::<Vec<_>>().join("\n\n"))?;
        console::note(took(begin.elapsed()));
    }
    Ok(())
}

/// The time that a command took.
pub(super) fn took(time: Duration) -> String {
    let threads = rayon::current_num_threads();
    let plural = if threads == 1 { "" } else { "s" };
    match time.as_secs_f64() {
        seconds if seconds < 60.0 => format!("took {seconds:.1} s on {threads} thread{plural}"),
        seconds => {
            let whole = humantime::format_duration(Duration::from_secs(seconds.round() as u64));
            format!("took {whole} on {threads} thread{plural}")
        }
    }
}
