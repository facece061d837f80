//! The kd-tree: nodes of eight bytes, lists of primitives, one plane test a step.
//!
//! Space is split, not the set of triangles: a triangle is listed in each leaf that it lies in. There is no mailbox, as
//! there is none in the hardware (Nah et al. 2011): a triangle is tested again in each leaf of its that a ray comes to,
//! and every test is recorded.

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

pub use self::statics::KdTree;
pub use self::traverse::Forest;
