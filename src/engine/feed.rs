//! What an engine is fed with: the stream's items, all of them or a sample.

use super::sampling::WarmCaches;
use super::tally::Tally;
use super::{RunError, check};
use crate::engine::source::{FrameCounts, StoreWork};
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::memory::dram::command::ChannelLog;
use crate::stream::Item;

/// Gives an engine the items that it replays, and is told when.
pub(super) trait Feed<E> {
    /// The next item.
    fn next(&mut self) -> Result<Option<Item>, RunError<E>>;

    /// A frame is over.
    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError<E>>;

    /// Whether [`Feed::heard`] is to be called at the end of the cycle.
    fn hears(&self) -> bool {
        false
    }

    /// What the channels of the DRAM were asked for and given up to the end of the cycle, to be drained.
    fn heard(&mut self, _: &mut [&mut ChannelLog]) -> Result<(), RunError<E>> {
        Ok(())
    }

    /// So many rays are done.
    fn rays_over(&mut self, _: usize) {}

    /// Whether [`Feed::mark`] is to be called at the end of the cycle.
    fn marks(&self) -> bool {
        false
    }

    /// So much was counted up to now. Gives what the caches are to hold from now on, if that is something else.
    fn mark(&mut self, _: &Tally) -> Option<&WarmCaches> {
        None
    }
}

/// All items.
pub(super) struct Whole<'a, I> {
    pub items: I,
    pub spec: &'a ShadowCacheSpec,
    /// What was done with stores otherwise than recorded.
    pub stores: StoreWork,
}

impl<E, I: Iterator<Item = Result<Item, E>>> Feed<E> for Whole<'_, I> {
    fn next(&mut self) -> Result<Option<Item>, RunError<E>> {
        self.items.next().transpose().map_err(RunError::Source)
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError<E>> {
        self.stores += counts.stores;
        check::frame(counts, self.spec)
    }
}
