//! Machines with many cores, predicted from scale models.

mod data;
mod plot;
mod words;
mod write;

pub(crate) use data::{Extrapolation, Extrapolations, Figures, Prediction, ScaleModel};
pub(crate) use words::{grid, verdict};
