//! umbrasim: a simulator of a fixed-function ray-tracing accelerator that culls shadow rays with mode words kept per
//! primitive.

pub mod engine;
pub mod machine;
pub mod memory;
pub mod quantity;
pub mod ranged;
pub mod scene;
pub mod stats;
pub mod stream;
