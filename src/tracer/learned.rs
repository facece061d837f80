//! Bits that the updates of a frame have set so far, in the order of the stream. A band knows only its own updates.

use rustc_hash::FxHashMap;

use super::lane::BandRecord;
use crate::stream::{Chunk, Effect};

/// Bits set, by mode word.
#[derive(Clone, Debug, Default)]
pub(super) struct Learned(FxHashMap<u32, u32>);

impl Learned {
    /// Takes the next band of the frame, and marks its updates that repeat those of earlier bands.
    pub(super) fn settle(&mut self, chunk: &mut Chunk, record: &mut BandRecord) {
        for fresh in record.fresh.drain(..) {
            let known = self.0.entry(fresh.word).or_default();
            let effect = Effect::of_bits(fresh.bits, 0, *known);
            if effect != Effect::Changes {
                chunk.set_effect(fresh.at, Effect::Repeats);
                record.totals.repeated_updates += 1;
            }
            *known |= fresh.bits;
        }
    }
}
