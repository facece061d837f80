//! What a command says on standard error while it works: notes, warnings, and whether progress is shown.

use std::fmt::Display;
use std::io::{IsTerminal, Write, stderr};
use std::sync::atomic::{AtomicBool, Ordering};

static QUIET: AtomicBool = AtomicBool::new(false);

/// From here on nothing but errors is said.
pub(crate) fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether nothing but errors is said.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Says a line that is said even where a command is quiet. A standard error that is full or closed loses it: the
/// results do not depend on what is said.
pub(crate) fn tell(text: impl Display) {
    _ = writeln!(stderr(), "{text}");
}

/// Says a line.
pub(crate) fn note(text: impl Display) {
    if !is_quiet() {
        tell(text);
    }
}

/// Says that something is not as a user is likely to want it; in yellow on a terminal.
pub(crate) fn warn(text: impl Display) {
    let is_coloured = stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    note(if is_coloured { format!("\x1b[33mwarning:\x1b[0m {text}") } else { format!("warning: {text}") });
}
