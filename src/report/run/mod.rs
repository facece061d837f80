//! The report of a run: effects of culling policies, measurements of machines, pictures, and a page that shows all.

mod choice;
mod files;
mod findings;
pub(super) mod frames_csv;
mod limits;
mod machine_columns;
mod machine_run;
mod notices;
mod over_time;
mod page;
pub(crate) mod pictures;
mod plots;
mod results;
mod steady;
mod summary;
mod tables;
mod terminal;
mod write;

pub(crate) use files::{RunFiles, read_summary};
pub(crate) use machine_columns::{CountedColumn, counted_columns};
pub(crate) use machine_run::{Asked, MachineRun};
pub(crate) use over_time::{OverTime, Span};
pub(in crate::report) use results::machine_rows;
pub(crate) use summary::{
    FrameResult, LightWrong, MachineSummary, PolicySummary, Psnr, SCHEMA, Saved, SceneSummary, Summary,
};
pub(crate) use tables::replayed;
pub(crate) use terminal::{replay_verdict, terminal, verdict};
pub(crate) use write::redraw;

#[cfg(test)]
pub(crate) mod tests;
