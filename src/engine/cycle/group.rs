//! A chunk of the stream that is under way.

use std::sync::Arc;

use crate::stream::Chunk;

/// A chunk of which somebody still needs a ray.
#[derive(Debug)]
pub(super) struct Group {
    pub chunk: Arc<Chunk>,
    /// The children of each ray, in the stream's order.
    pub children: Vec<Vec<usize>>,
}
