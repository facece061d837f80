//! The ray stream: what the tracer records and the machine replays. It is the only interface between the functional and
//! the timing side.
//!
//! A stream is a [`Header`], then frames. A frame is a [`FrameInfo`], chunks of rays, and the culling policy's steps at
//! the frame's end. Rays come in pixel groups: a primary ray and all rays that follow from it, never split over chunks.
//! A ray holds the steps of its traversal and, separately, the policy's steps for it. Steps hold ids, not addresses:
//! the replay lays out memory.

mod blocks;
pub(crate) mod check;
pub(crate) mod chunk;
mod columns;
mod error;
mod extent;
mod fault;
pub(crate) mod format;
mod header;
pub(crate) mod inspect;
mod item;
mod limits;
mod packed;
pub(crate) mod reader;
pub(crate) mod step;
mod totals;
mod version;
pub(crate) mod violation;
pub(crate) mod writer;

#[cfg(test)]
mod tests;

pub use check::Checker;
pub use chunk::{Chunk, Decision, Outcome, Ray, RayHead, RayKind};
pub use error::{Place, StreamError};
pub use extent::Extent;
pub use fault::Fault;
pub use format::FrameEntry;
pub use header::{Header, NO_RECORD, StoreEntries, Structure};
pub use item::{FrameInfo, Item};
pub use packed::PackedChunk;
pub use reader::StreamReader;
pub use step::{Effect, Step, Stop, Store};
pub use totals::Totals;
pub use violation::Violation;
pub use writer::StreamWriter;
