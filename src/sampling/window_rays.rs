//! The rays of a window with its lead-in and tail. All machines of a pass share them: the first machine that needs them
//! joins or packs them for all.

use std::sync::{Arc, OnceLock};

use crate::stream::{Chunk, PackedChunk};

/// Of lead-in, window and tail.
type Three<T> = [T; 3];

/// The rays of one window.
#[derive(Debug, Default)]
pub(crate) struct WindowRays {
    chunks: OnceLock<Three<Arc<Chunk>>>,
    packed: OnceLock<Arc<PackedRays>>,
}

/// The packed rays of one window.
#[derive(Debug)]
pub(super) struct PackedRays(Three<PackedChunk>);

impl WindowRays {
    /// The chunks, made by `make` at the first call.
    pub(super) fn chunks(&self, make: impl FnOnce() -> Three<Chunk>) -> Three<Arc<Chunk>> {
        self.chunks.get_or_init(|| make().map(Arc::new)).clone()
    }

    /// The packed chunks.
    pub(super) fn packed(&self, chunks: Three<&Chunk>) -> Arc<PackedRays> {
        Arc::clone(self.packed.get_or_init(|| Arc::new(PackedRays(chunks.map(PackedChunk::new)))))
    }
}

impl PackedRays {
    /// The unpacked chunks.
    pub(super) fn unpack(&self) -> Three<Arc<Chunk>> {
        self.0.each_ref().map(|packed| Arc::new(packed.unpack()))
    }

    /// Bytes in memory.
    pub(super) fn bytes(&self) -> usize {
        self.0.iter().map(PackedChunk::bytes).sum()
    }
}
