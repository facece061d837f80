//! umbrasim: a simulator of a fixed-function ray-tracing accelerator that culls shadow rays with mode words kept per
//! primitive.

pub mod quantity;
pub mod ranged;
pub mod report;
pub mod scene;
pub mod stats;
pub mod stream;
