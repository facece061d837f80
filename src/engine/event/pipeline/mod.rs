//! What all units that work on rays have in common: an L1, rays that wait for their data, and a pipeline.

mod ahead;
mod foresight;
mod lines;
mod operations;
mod unit;

pub(crate) use self::unit::{Pipeline, Stages};
