//! The report on reuse: misses of caches of all sizes.

mod data;
mod plot;
mod results;
mod write;

pub(crate) use data::{ReuseSummary, grid};
pub(crate) use plot::{figure, finding};
