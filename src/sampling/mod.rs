//! Sampling: windows (runs of about equally many pixels) are drawn from strata of a stream. Each is replayed and
//! measured by itself, with a lead-in and a tail, on warm caches. All accesses pass through the caches' tags alone.

mod auto;
mod axis;
mod baseline;
mod covariates;
mod cutter;
mod estimate;
mod figures;
mod findings;
mod grow;
mod job;
mod job_cache;
mod l2_tags;
mod lane;
mod others;
mod pass;
mod path_tags;
mod performed;
mod plan;
mod regression;
mod requests;
mod sample;
mod seats;
mod strata;
#[cfg(test)]
mod tests;
mod verdict;
mod waiting;
mod window_rays;
mod windows;
mod word_tags;

pub(crate) use self::auto::{auto, pays};
pub(crate) use self::grow::Against;
pub(crate) use self::pass::PerMachine;
pub(crate) use self::plan::{Cut, Lengths};
pub(crate) use self::sample::{sample, sample_together, sample_until_within};
pub(crate) use self::verdict::Verdict;
