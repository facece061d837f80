//! Bounds of a stream on a machine, in closed form. Lower bound: the minimum work over the maximum rate of each
//! resource. Upper bound: all accesses miss, and everything happens one after another.

mod closed_form;
mod host;
mod lines;
mod phases;
mod steps;
mod sums;

pub(super) use self::closed_form::run;
pub(super) use self::phases::Bound;
