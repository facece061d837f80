//! Experiments: scene x policies x machines, as a RON file says.

pub mod frames;
pub mod ron_file;
pub mod spec;
