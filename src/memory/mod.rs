//! Caches and DRAM. This room knows addresses and classes of traffic, never rays: whoever waits for data is a number.

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

/// A part that can be woken and that answers are sent to, by its number in the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PartId(pub u32);

/// What a cache asks of the level below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// The line.
    pub line: LineAddr,
    /// What it is for.
    pub class: TrafficClass,
    /// Whether data goes down; else the line is to come up.
    pub write: bool,
    /// How much data moves.
    pub bytes: Bytes,
    /// Who gets the answer.
    pub from: PartId,
    /// Whether it is for one of those whose misses are counted apart.
    pub marked: bool,
}

/// Wakes parts at later cycles; the engine's scheduler is one.
pub trait Wake {
    /// Part `part` has, or may have, something to do in cycle `at`.
    fn wake(&mut self, part: PartId, at: u64);
}
