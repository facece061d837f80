//! Acceleration structures: a static tree built once, a dynamic tree built every frame, both under one root.
//!
//! A scene in which nothing moves has no dynamic tree, and its root is the root of the static tree. Each kind of tree
//! implements the traits of `structure` in its own folder and has a variant in `kind`.

mod block;
mod bvh;
mod kdtree;
mod kind;
mod lanes;
mod query;
mod ray;
mod shaft;
mod slabs;
mod spec;
mod statics;
mod steps;
mod structure;
#[cfg(test)]
mod tests;
mod trail;
mod triangle;
mod world;

pub use self::query::{Hit, Order, Scope};
pub use self::ray::{Boxes, Ray};
pub use self::shaft::{Relation, Shaft, Sight};
pub use self::spec::{AccelSpec, KdLayout, Quality};
pub use self::statics::Accel;
pub use self::steps::Steps;
pub use self::trail::{Fresh, Mark, Observer, Path, Silent, Trail};
pub use self::triangle::Record;
pub use self::world::World;
