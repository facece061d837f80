//! The chart of saving against error over several runs.

mod data;
mod plot;
mod write;

pub(crate) use data::ChartSummary;
pub(crate) use plot::finding;
