//! Trees of boxes: the binary BVH and the 8-wide BVH, with the same code for both widths.

mod ancestry;
mod build;
mod copies;
mod eight;
mod forest;
mod packed;
mod pair;
mod question;
mod sight;
mod stack;
mod statics;
mod tree;
mod walk;

pub(super) use self::forest::Forest;
pub(super) use self::statics::Bvh;
