//! Reports: the results of a run or study as numbers (`summary.json` and CSV tables), plots, pictures and a page that
//! shows all.
//!
//! This module sees statistics and pictures as data, and nothing of the code that made them. A report is a folder of
//! files: `data` holds its numbers, each plot has a file, and `write` lists its files (`writer::Report`). Only
//! `writer` writes them.

#![warn(unreachable_pub)]

pub(crate) mod chart;
mod csv_table;
pub(crate) mod diff;
mod draw;
mod error;
pub mod explain;
pub(crate) mod extrapolate;
pub(crate) mod file_names;
pub(crate) mod format;
mod grid;
pub(crate) mod ladder_map;
mod numbers;
pub(crate) mod pareto;
pub(crate) mod replay;
mod results;
pub(crate) mod reuse;
pub(crate) mod run;
pub(crate) mod space;
pub(crate) mod split;
pub(crate) mod stress;
pub(crate) mod sweep;
mod template;
mod terminal;
mod writer;

pub(crate) use error::ReportError;
pub(crate) use grid::{Grid, definitions, drawn, drawn_most, paragraph};
pub(crate) use numbers::read_numbers;
pub(crate) use writer::{SUMMARY_FILE, write};
