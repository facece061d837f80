//! Gaussian processes: expected value and standard deviation of a smooth function of several inputs between the points
//! where it is known (Rasmussen and Williams 2006, "Gaussian Processes for Machine Learning"; comments cite its
//! sections).
//!
//! Why no crate does this: see "A Gaussian process of our own" in `docs/decisions/index.md`.

#![warn(unreachable_pub)]

mod cholesky;
mod fit;
mod kernel;
mod process;

pub(crate) use fit::fit;
pub(crate) use kernel::{Group, Kernel};
pub(crate) use process::{Prediction, Process};
