//! Caches and DRAM. This module knows addresses and traffic classes, never rays: a requester is a `PartId` or a number.

pub(crate) mod allocation;
pub(crate) mod bank;
pub mod cache;
pub mod dram;
pub mod l2;
pub(crate) mod mshr;
pub(crate) mod paged;
pub(crate) mod queue;
pub mod replacement;
pub(crate) mod reuse;
pub(crate) mod ring;
pub mod tags;
pub(crate) mod timeless;

use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// A part of the machine that can be woken or can receive answers, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PartId(pub u32);

/// A request from a cache to the level below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// The line.
    pub line: LineAddr,
    /// The traffic class.
    pub class: TrafficClass,
    /// Whether data moves down (a write); a read brings the line up.
    pub write: bool,
    /// Bytes moved.
    pub bytes: Bytes,
    /// The part that gets the answer.
    pub from: PartId,
    /// Whether a read miss counts among the attributed misses (`Served::attributed`).
    pub attributed: bool,
}

/// Wakes parts in later cycles; the engine's scheduler implements this.
pub trait Wake {
    /// Part `part` has, or may have, work in cycle `at`.
    fn wake(&mut self, part: PartId, at: u64);
}
