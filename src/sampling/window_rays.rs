//! The rays of a window and of what is replayed beside it. They are the same on every machine of a pass: whoever needs
//! them first puts them together, or packs them, for all.

use std::sync::{Arc, OnceLock};

use crate::stream::{Chunk, PackedChunk};

/// A chunk of what comes before a window, of its own, and of what comes behind it.
type Three<T> = [T; 3];

/// The rays of one window.
#[derive(Debug, Default)]
pub(crate) struct WindowRays {
    chunks: OnceLock<Three<Arc<Chunk>>>,
    packed: OnceLock<Arc<PackedRays>>,
}

/// They, packed.
#[derive(Debug)]
pub(super) struct PackedRays(Three<PackedChunk>);

impl WindowRays {
    /// The chunks, which `make` makes.
    pub(super) fn chunks(&self, make: impl FnOnce() -> Three<Chunk>) -> Three<Arc<Chunk>> {
        self.chunks.get_or_init(|| make().map(Arc::new)).clone()
    }

    /// The chunks, packed.
    pub(super) fn packed(&self, chunks: Three<&Chunk>) -> Arc<PackedRays> {
        Arc::clone(self.packed.get_or_init(|| Arc::new(PackedRays(chunks.map(PackedChunk::new)))))
    }
}

impl PackedRays {
    /// The chunks.
    pub(super) fn unpack(&self) -> Three<Arc<Chunk>> {
        self.0.each_ref().map(|packed| Arc::new(packed.unpack()))
    }

    /// What they take in memory.
    pub(super) fn bytes(&self) -> usize {
        self.0.iter().map(PackedChunk::bytes).sum()
    }
}
