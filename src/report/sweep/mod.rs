//! The report of a sweep: savings and costs of culling on machines that differ in named fields.

mod bytes;
mod curves;
mod data;
mod fields;
mod front;
mod heat_map;
mod results;
mod tornado;
mod values;
mod write;

pub(crate) use data::{Change, Own, SweepPoint, SweepSummary, grid, label};
pub(crate) use values::shown;
pub(crate) use write::{finding, frames};
