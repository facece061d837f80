//! Gaussian processes: what a smooth function of several inputs is between the points at which it is known, and how
//! sure that is (Rasmussen and Williams 2006, "Gaussian Processes for Machine Learning"; section numbers in comments
//! are theirs).
//!
//! Why no crate has this place: see "A Gaussian process of our own" in `docs/decisions/index.md`.

#![warn(unreachable_pub)]

mod cholesky;
mod fit;
mod kernel;
mod process;

pub(crate) use fit::fit;
pub(crate) use kernel::{Group, Kernel};
pub(crate) use process::{Prediction, Process};
