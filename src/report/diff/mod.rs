//! The comparison of two reports: fields of the configuration that differ, and figures that differ.

mod config;
mod data;
mod figures;
mod plot;
mod write;

pub(crate) use data::Diff;
