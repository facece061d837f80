//! The report on speed against accuracy of the fidelity levels.

mod data;
mod level;
mod plot;
mod report;
mod results;
mod run;
mod timing;
mod write;

pub(crate) use data::ParetoSummary;
#[cfg(test)]
pub(in crate::report) use data::tests::summary as with_timings;
#[cfg(test)]
pub(crate) use level::Rung;
pub(crate) use report::ParetoReport;
pub(crate) use run::{Figures, Found, Measured, Run};
pub(crate) use timing::Timing;
