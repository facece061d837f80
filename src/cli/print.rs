//! Standard output.

use std::fmt::Display;
use std::io::{self, Write};

use anyhow::{Context, Result};

use crate::console;
use crate::output::is_standard_output_claimed;

/// Prints a line, to standard error if standard output is one of the command's files. A closed pipe (as with `| head`)
/// is no error.
pub(super) fn print(text: impl Display) -> Result<()> {
    if is_standard_output_claimed() {
        console::tell(&text);
        return Ok(());
    }
    match writeln!(io::stdout(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(()),
    }
}
