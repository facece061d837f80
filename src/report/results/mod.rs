//! `results.csv`: every number that a report measured, one a row, for pandas, R and other tools.
//!
//! The rows are the numbers of `summary.json`, walked along their declarations in `explain`. A metric's name is its path
//! there without the names of policies, machines, parts and classes, which are columns: `bytes.l2.node` is the metric
//! `bytes` of part `l2` and class `node`. A new counter appears by its declaration alone.

mod dictionary;
mod names;
mod row;
mod table;
#[cfg(test)]
mod tests;
mod walk;

pub(super) use names::Family;
pub(super) use row::{Amount, Row, Scope, Subject};
pub(super) use table::files;
pub(super) use walk::Walk;

use super::error::ReportError;

/// A report whose numbers are rows.
pub(super) trait Results {
    /// The run's name.
    fn run(&self) -> &str;

    /// The scene's name.
    fn scene(&self) -> &str;

    /// Fields of machines that differ from row to row, each a column of its own.
    fn varied(&self) -> Vec<&str> {
        Vec::new()
    }

    /// Hands over all rows, in a fixed order.
    ///
    /// # Errors
    /// A number has no form in JSON, or `take` fails.
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError>;
}

/// Takes a row.
pub(super) type Take<'t> = dyn FnMut(&Row<'_>) -> Result<(), ReportError> + 't;
