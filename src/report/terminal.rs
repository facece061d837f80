//! The width of the terminal, for tables.

/// Columns if the output goes to no terminal and `COLUMNS` is not set.
const USUAL: usize = 80;
/// The fewest columns for tables.
const LEAST: usize = 40;

/// The number of columns: from the environment's `COLUMNS`, or else from the terminal.
pub(crate) fn width() -> usize {
    let told = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let width = told.or_else(|| terminal_size::terminal_size().map(|(width, _)| usize::from(width.0)));
    width.unwrap_or(USUAL).max(LEAST)
}
