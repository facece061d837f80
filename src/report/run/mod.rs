//! The report of a run: what culling policies did, what machines measured, pictures, and a page that shows all.

mod files;
mod findings;
pub(super) mod frames_csv;
mod machine_columns;
mod page;
pub mod pictures;
mod plots;
mod steady;
mod summary;
mod tables;
mod write;

pub use files::{RunFiles, read_summary};
pub use summary::{
    Asked, Counts, FrameResult, FrameSummary, LightWrong, MachineRun, MachineSummary, PolicySummary, Psnr, SCHEMA,
    Saved, SceneSummary, Summary,
};
pub use tables::{replayed, terminal};
pub use write::redraw;

#[cfg(test)]
pub mod tests;
