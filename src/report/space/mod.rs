//! The report of a space of machines.

mod axis;
mod data;
mod front;
mod predicted;
mod results;
mod sensitivity;
mod tables;
mod write;

pub(crate) use data::{Accuracy, Design, Errors, PolicyPixels, Sensitivity, Size, SpaceSummary};
