//! Two reports beside each other: what of the configuration differs, and which figures.

mod config;
mod data;
mod figures;
mod plot;
mod write;

pub(crate) use data::Diff;
