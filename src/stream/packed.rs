//! Compressed chunks, which stay in memory for long.

use lz4_flex::block::{compress_prepend_size, decompress_size_prepended};

use super::chunk::Chunk;
use super::columns::{self, chunk_len, put_chunk};
use super::version::Version;

/// A chunk packed as in a file: it takes about a tenth of the chunk's memory.
#[derive(Clone, Debug)]
pub struct PackedChunk {
    payload: Vec<u8>,
    attributed: bool,
}

impl PackedChunk {
    /// Packs `chunk`.
    pub fn new(chunk: &Chunk) -> Self {
        let mut payload = Vec::with_capacity(chunk_len(chunk));
        put_chunk(chunk, &mut payload);
        Self { payload: compress_prepend_size(&payload), attributed: chunk.is_attributed() }
    }

    /// The chunk.
    pub fn unpack(&self) -> Chunk {
        let payload = decompress_size_prepended(&self.payload).expect("it was packed here");
        let mut chunk = columns::chunk(&payload, Version::CURRENT).expect("the payload is of a chunk");
        if self.attributed {
            chunk.attribute();
        }
        chunk
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> usize {
        self.payload.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{LightId, NodeId, PixelId, PrimitiveId, TriangleSlot};
    use crate::stream::{Decision, Outcome, RayHead, RayKind, Step, Stop};

    #[test]
    fn what_is_packed_comes_out_as_it_was() {
        let mut chunk = Chunk::default();
        assert_eq!(PackedChunk::new(&chunk).unpack(), chunk);
        for pixel in 0..500 {
            let head = RayHead {
                kind: RayKind::Primary,
                light: LightId(0),
                decision: Decision::Trace,
                outcome: if pixel % 3 == 0 { Outcome::Hit(PrimitiveId(pixel)) } else { Outcome::Miss },
                pixel: PixelId(pixel),
                parent: 0,
            };
            let node = |index| Step::Node(NodeId(index)).pack();
            let triangle = Step::Triangle { slot: TriangleSlot(pixel), stop: Stop::Hit }.pack();
            chunk.push(head, &[node(0), node(1), node(pixel % 2 + 2), triangle], &[]);
        }
        let unmarked = PackedChunk::new(&chunk);
        assert_eq!(unmarked.unpack(), chunk);
        chunk.attribute();
        let packed = PackedChunk::new(&chunk);
        assert!(packed.unpack().is_attributed() && packed.unpack() == chunk && !unmarked.unpack().is_attributed());
        assert!(packed.bytes() < chunk.bytes() / 4, "{} of {} bytes", packed.bytes(), chunk.bytes());
    }
}
