//! Trees of boxes: the binary BVH and the 8-wide one, by one code for both widths.

mod ancestry;
mod build;
mod copies;
mod forest;
mod sight;
mod statics;
mod tree;
mod walk;

pub use self::forest::Forest;
pub use self::statics::Bvh;
