//! The failure map of the fidelity levels.

mod data;
mod plot;
mod write;

pub(crate) use data::{Axis, Covered, Figure, LadderMap, Point, Row, grid, verdict};
