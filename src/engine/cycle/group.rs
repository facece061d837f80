//! A chunk of the stream that is in use.

use std::sync::Arc;

use crate::stream::Chunk;

/// A chunk with rays that are still needed.
#[derive(Debug)]
pub(super) struct Group {
    pub chunk: Arc<Chunk>,
    /// The children of each ray, in the stream's order.
    pub children: Vec<Vec<usize>>,
}
