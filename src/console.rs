//! Messages of a command on standard error: notes, warnings, and whether progress is shown.

use std::fmt::Display;
use std::io::{IsTerminal, Write, stderr};
use std::sync::atomic::{AtomicBool, Ordering};

static QUIET: AtomicBool = AtomicBool::new(false);

/// Suppresses notes, warnings and progress from now on.
pub(crate) fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether notes, warnings and progress are suppressed.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Writes a line even if the command is quiet. If standard error is full or closed, the line is lost: results do not
/// depend on messages.
pub(crate) fn tell(text: impl Display) {
    _ = writeln!(stderr(), "{text}");
}

/// Writes a line, unless the command is quiet.
pub(crate) fn note(text: impl Display) {
    if !is_quiet() {
        tell(text);
    }
}

/// Warns of something that the user probably does not want; in yellow on a terminal.
pub(crate) fn warn(text: impl Display) {
    let is_coloured = stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    note(if is_coloured { format!("\x1b[33mwarning:\x1b[0m {text}") } else { format!("warning: {text}") });
}
