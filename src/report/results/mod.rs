//! `results.csv`: every number that a report measured, one a row, for pandas, R and other tools.
//!
//! The rows are the numbers of `summary.json`, walked along their declarations in `explain`. A metric's name is its
//! path there without the names of policies, machines, parts and classes, which are columns: `bytes.l2.node` is the
//! metric `bytes` of part `l2` and class `node`. A new counter appears by its declaration alone.

mod columns;
mod dictionary;
mod names;
#[cfg(feature = "parquet")]
mod parquet;
mod row;
mod table;
#[cfg(test)]
mod tests;
mod walk;

pub(super) use names::Family;
pub(super) use row::{Amount, Results, Row, Scope, Subject, Take};
pub(super) use table::files;
pub(super) use walk::Walk;
