//! The demand of a stream on machines, from one pass: the load on each resource of any machine similar to that of the
//! pass, without a replay of its own.
//!
//! The pass is a replay by [`super::Level::Profile`]; the caches of all machines watch it. The load on each part of a
//! machine is then compared with its rate. An [`Estimate`] is rough: a surrogate learns its errors.

mod caches;
mod estimate;
mod filling;
mod pass;
#[cfg(test)]
mod tests;

pub use self::estimate::Estimate;
pub(crate) use self::pass::estimates;
