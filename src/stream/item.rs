//! The pieces of a stream in order.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::chunk::Chunk;
use super::totals::Totals;

/// A frame of a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameInfo {
    /// The frame's number.
    pub number: u32,
    /// Nodes of this frame's dynamic tree.
    pub dynamic_nodes: u32,
    /// Triangle records of this frame's dynamic tree.
    pub dynamic_slots: u32,
    /// Entries of this frame's dynamic primitive lists.
    pub dynamic_list_entries: u32,
}

/// A piece of a stream, in order: every frame is a `Frame`, any number of `Rays`, and an `End`.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A frame begins.
    Frame(FrameInfo),
    /// Rays of the frame.
    Rays(Arc<Chunk>),
    /// The frame ends.
    End {
        /// The policy's steps at the frame's end (its sweep), as packed `Step`s.
        policy: Arc<Vec<u32>>,
        /// The tracer's counters of the frame.
        totals: Totals,
    },
}
