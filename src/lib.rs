//! umbrasim: a simulator of a fixed-function ray-tracing accelerator that culls shadow rays with mode words kept per
//! primitive.

pub mod accel;
pub mod cli;
pub mod culling;
pub(crate) mod engine;
pub mod experiment;
pub(crate) mod input;
pub mod machine;
pub mod memory;
pub mod named;
pub mod new_file;
pub mod quantity;
pub(crate) mod random;
pub mod ranged;
pub mod reference;
pub mod replay;
pub mod report;
pub mod ron_file;
pub(crate) mod sampling;
pub mod scene;
pub mod stats;
pub mod stream;
pub mod tracer;
pub mod validate;
