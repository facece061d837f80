//! The report on speed against accuracy of the fidelity levels.

mod data;
mod level;
mod plot;
mod report;
mod run;
mod timing;
mod write;

pub use data::ParetoSummary;
pub use level::Rung;
pub use report::ParetoReport;
pub use run::{Figures, Found, Measured, Run};
pub use timing::Timing;
