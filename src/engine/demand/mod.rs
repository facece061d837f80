//! What a stream asks of machines, from one pass: what each resource of any machine like the one of the pass is asked
//! for, without a replay of its own.
//!
//! The pass is a replay by [`super::Level::Profile`] that watches reuse distances. Misses of caches of any size and any
//! number of ways are read from them; what each part of a machine is then asked for is counted against what it can do.
//! An [`Estimate`] is rough: its errors are what a surrogate learns.

mod distances;
mod estimate;
mod pass;
#[cfg(test)]
mod tests;
mod watch;

pub use self::estimate::Estimate;
pub use self::pass::Demand;
pub(crate) use self::pass::demand;
