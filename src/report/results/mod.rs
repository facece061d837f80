//! `results.csv`: every number that a report measured, one per row, for pandas, R and other tools.
//!
//! The rows are the numbers of `summary.json`, found through their declarations in `explain`. A metric's name is its
//! path there without the names of policies, machines, parts and classes, which are columns: `bytes.l2.node` is the
//! metric `bytes` of part `l2` and class `node`. A new counter needs only its declaration to appear here.

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
