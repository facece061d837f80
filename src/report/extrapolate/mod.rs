//! Machines of many cores as their scale models predict them.

mod data;
mod plot;
mod words;
mod write;

pub(crate) use data::{Extrapolation, Extrapolations, Figures, Prediction, ScaleModel};
pub(crate) use words::{grid, verdict};
