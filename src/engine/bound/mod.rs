//! Bounds that no machine of a spec can beat on a stream, in closed form: what must be done at least, over what can be
//! done a cycle at most. And an upper bound: everything missed, one thing after another.

mod closed_form;
mod host;
mod lines;
mod phases;
mod steps;
mod sums;

pub(super) use self::closed_form::run;
pub(super) use self::phases::Bound;
