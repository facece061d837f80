//! The terminal that tables are for.

/// Columns where output goes to no terminal, and nothing says otherwise.
const USUAL: usize = 80;
/// The fewest columns that tables are made for.
const LEAST: usize = 40;

/// The columns of the terminal: what the environment's `COLUMNS` says, or what the terminal has.
pub(crate) fn width() -> usize {
    let told = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let width = told.or_else(|| terminal_size::terminal_size().map(|(width, _)| usize::from(width.0)));
    width.unwrap_or(USUAL).max(LEAST)
}
