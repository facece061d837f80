//! The report of a run: what culling policies did, what machines measured, pictures, and a page that shows all.

mod files;
mod findings;
mod frames_csv;
mod page;
pub mod pictures;
mod plots;
mod summary;
mod tables;
mod write;

pub use files::{RunFiles, read_summary};
pub use summary::{
    Counts, FrameResult, FrameSummary, LightWrong, MachineRun, MachineSummary, PolicySummary, Psnr, SCHEMA, Saved,
    SceneSummary, Summary,
};
pub use tables::{replayed, terminal};
pub use write::redraw;

#[cfg(test)]
pub mod tests;
