//! The report of a sweep: what culling saves and costs on machines that differ in named fields.

mod data;
mod plot;
mod results;
mod write;

pub(crate) use data::{Change, SweepPoint, SweepSummary, grid};
