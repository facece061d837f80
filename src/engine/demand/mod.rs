//! What a stream asks of machines, from one pass: what each resource of any machine like the one of the pass is asked
//! for, without a replay of its own.
//!
//! The pass is a replay by [`super::Level::Profile`] that is watched by the caches of all machines. What each part of a
//! machine is then asked for is counted against what it can do. An [`Estimate`] is rough: its errors are what a
//! surrogate learns.

mod caches;
mod estimate;
mod filling;
mod pass;
#[cfg(test)]
mod tests;

pub use self::estimate::Estimate;
pub(crate) use self::pass::estimates;
