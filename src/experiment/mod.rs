//! Experiments: a scene, policies and machines, given by a RON file.

#![warn(unreachable_pub)]

mod changed;
pub(crate) mod dram_export;
mod export_file;
pub(crate) mod exports;
pub(crate) mod extrapolate;
mod files;
mod frame_reuse;
pub(crate) mod frames;
pub mod identities;
pub(crate) mod interval_export;
pub(crate) mod ladder_map;
pub(crate) mod line_export;
mod load;
pub mod need;
mod over_time;
pub mod paper;
pub mod pareto;
mod progress;
pub(crate) mod replay;
pub(crate) mod reuse;
pub(crate) mod run;
mod set;
pub(crate) mod space;
pub(crate) mod spec;
mod split;
pub(crate) mod stress;
mod stress_models;
pub mod sweep;
pub(crate) mod timeline;
pub(crate) mod trace;
pub(crate) mod validation;
pub(crate) mod warnings;

pub(crate) use crate::scene::composed::starter::config as scene_around;
pub(crate) use files::machine_with;
pub(crate) use files::read_dram_part;
pub use files::read_machine;
pub(crate) use load::read_scene;
pub use load::{Experiment, ExperimentError, Overrides};
pub use set::Setting;
pub(crate) use set::check_once;
pub(crate) use spec::check_name;
