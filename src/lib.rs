//! umbrasim simulates a fixed-function ray-tracing accelerator that culls shadow rays with mode words kept per
//! primitive, and measures what culling saves, what it costs, and what it gets wrong.
//!
//! # Flow
//!
//! ```text
//!  scene, animation ──> tracer ──> ray stream ──> replay ──> statistics ──> report
//!                         ^  │      (a file)        ^
//!        culling policies ┘  └> pictures      machine's spec
//!                                  │
//!              reference renderer ─┴> wrong pixels and decisions ──> report
//! ```
//!
//! The *functional wing* turns frames into rays. Every ray is traced once without culling, and the stream of each
//! policy has the rays that the policy leaves. The *timing wing* replays a stream on a machine. Streams are the only
//! connection between the two, so that machines can be compared on the same rays, and policies on the same machine.
//!
//! # Layers
//!
//! Each layer uses only layers above it in this table; `tests/layering.rs` checks it.
//!
//! | layer | rooms |
//! |---|---|
//! | common ground | [`quantity`], [`ranged`], [`named`], [`ron_file`], [`stats`], [`stream`] |
//! | functional wing | [`scene`], [`reference`](mod@reference), [`accel`], [`culling`], [`tracer`] |
//! | timing wing | [`memory`], [`machine`], engines, sampling, [`replay`](mod@replay) |
//! | above both | [`validate`], reports, [`experiment`], the command line ([`cli`]) |
//!
//! # Reading order
//!
//! 1. [`stream`]: the record of a traced ray, and the content of a file of rays.
//! 2. [`culling`]: what a policy stores and decides, then one policy, such as [`culling::last_occluder`].
//! 3. [`tracer`]: how one tracing of a frame serves all policies.
//! 4. [`machine`]: the parts of a machine; docs/model has the rules that engines follow.
//! 5. [`replay`](mod@replay): how a stream is replayed, and at which fidelity levels.
//! 6. [`experiment`]: scene, policies and machines together.
//!
//! `examples/` has programs that replay a stream, define a culling policy, and build a machine in code.
//!
//! # Example
//!
//! Replays a recorded stream on a shipped machine, and prints the DRAM bytes of each class of traffic:
//!
//! ```
//! use umbrasim::experiment::read_machine;
//! use umbrasim::replay::{Fidelity, Replay, StreamFile};
//! use umbrasim::stream::StreamReader;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let machine = read_machine("configs/machines/small.ron".as_ref())?;
//! let stream = "traces/quickstart.rays".as_ref();
//! let header = StreamReader::open(stream)?.header().clone();
//! let stats = Replay::new(&machine, &header)?.fidelity(Fidelity::Event).run(&StreamFile(stream))?;
//! for (class, bytes) in &stats.bytes["dram"] {
//!     println!("{:>13}  {bytes}", class.name());
//! }
//! # assert!(stats.bytes["dram"].len() > 2 && stats.moved("dram").0 > 0);
//! # Ok(())
//! # }
//! ```

#![warn(unreachable_pub)]
// `println!` panics if standard output is full or closed: the command line has a function for output.
#![deny(clippy::print_stdout)]
#![warn(clippy::missing_errors_doc)]

pub mod accel;
pub(crate) mod alike;
pub mod cli;
pub(crate) mod console;
pub(crate) mod counters;
pub mod culling;
pub(crate) mod energy;
pub(crate) mod engine;
pub mod experiment;
pub(crate) mod fields;
pub(crate) mod input;
pub(crate) mod json;
pub mod machine;
pub mod memory;
pub mod named;
pub(crate) mod output;
pub mod quantity;
pub(crate) mod random;
pub mod ranged;
pub mod reference;
pub mod replay;
pub mod report;
pub mod ron_file;
pub(crate) mod sampling;
pub mod scene;
pub(crate) mod shipped;
pub(crate) mod size;
pub(crate) mod spread;
pub mod stats;
pub mod stream;
pub(crate) mod student;
pub(crate) mod surrogate;
pub mod tracer;
pub mod validate;
