//! Sampling: of each stratum of consecutive windows (runs of pixels of about the same number of rays) some are replayed
//! and measured, each by itself, between parts of others and behind warm caches; the accesses of all others go through
//! the caches' tags alone.

mod auto;
mod axis;
mod cutter;
mod estimate;
mod figures;
mod findings;
mod job;
mod kept;
mod known;
mod l1_tags;
mod l2_tags;
mod pass;
mod plan;
mod regression;
mod sample;
mod strata;
#[cfg(test)]
mod tests;
mod windows;

pub(crate) use self::auto::auto;
pub(crate) use self::plan::Cut;
pub(crate) use self::sample::{sample, sample_until_within};
