//! umbrasim: a simulator of a fixed-function ray-tracing accelerator that culls shadow rays with mode words kept per
//! primitive.

pub mod accel;
pub mod cli;
pub(crate) mod counters;
pub mod culling;
pub mod energy;
pub mod engine;
pub mod experiment;
pub(crate) mod input;
pub mod machine;
pub mod memory;
pub mod named;
pub mod output;
pub mod quantity;
pub mod ranged;
pub mod reference;
pub mod report;
pub mod ron_file;
pub mod scene;
pub(crate) mod spread;
pub mod stats;
pub mod stream;
pub mod tracer;
pub mod validate;
