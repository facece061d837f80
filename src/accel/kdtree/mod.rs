//! The kd-tree: nodes of eight bytes, lists of primitives, one plane test per step.
//!
//! The tree splits space, not the set of triangles: each leaf lists every triangle that reaches into it. There is no
//! mailbox, as in the hardware (Nah et al. 2011). A ray tests a triangle again in each leaf that lists it, and every
//! test is recorded.

mod bounds;
mod build;
mod built;
mod layout;
mod node;
mod shaft;
mod split;
mod stack;
mod statics;
#[cfg(test)]
mod tests;
mod traverse;

pub(super) use self::statics::KdTree;
pub(super) use self::traverse::Forest;
