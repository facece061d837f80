//! The stress report: where each policy is wrong, for how long, and how far the open questions of the published text
//! change it.

mod columns;
mod data;
mod failure_map;
mod over_frames;
mod results;
mod section;
mod write;

#[cfg(test)]
pub(crate) use data::Outcome;
#[cfg(test)]
pub(in crate::report) use data::tests::summary;
pub(crate) use data::{CaseSummary, Effect, FrameWrong, ModelVerdict, Shift, StressModel, StressPolicy, StressSummary};
