//! Experiments: scene x policies x machines, as a RON file says.

pub mod dram_export;
mod files;
pub mod frames;
pub mod identities;
pub mod ladder_map;
pub mod line_export;
mod load;
pub mod paper;
pub mod pareto;
mod progress;
pub mod replay;
pub mod reuse;
pub mod run;
pub mod spec;
mod split;
pub mod stress;
mod stress_models;
pub mod sweep;
mod text_file;
pub mod trace;
pub mod validation;

pub use files::read_machine;
pub use load::{Experiment, ExperimentError, Overrides};
