//! Reports: what a run or a study found, as numbers (`summary.json` and CSV tables), plots, pictures and a page that
//! shows all.
//!
//! This side sees statistics and pictures as data, never what made them. A report is a folder of files: `data` holds
//! its numbers, each plot has a file, and `write` lists its files ([`writer::Report`]), which [`writer`] alone writes.

pub mod chart;
mod csv_table;
mod draw;
mod error;
pub mod explain;
pub mod format;
mod grid;
pub mod ladder_map;
mod numbers;
pub mod pareto;
pub mod reuse;
pub mod run;
pub mod split;
pub mod stress;
pub mod sweep;
mod template;
mod writer;

pub use error::ReportError;
pub use grid::{Grid, drawn};
pub use numbers::read_numbers;
pub use writer::{SUMMARY_FILE, check_target, update, write};
