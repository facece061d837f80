//! What an engine is fed with: the stream's items, all of them or a sample.

use super::error::RunError;
use super::snapshot::Snapshot;
use super::source::FrameCounts;
use super::tally::Tally;
use super::warm::WarmCaches;
use crate::memory::dram::command::ChannelLog;
use crate::stream::Item;

/// What can be asked of an engine at the end of a cycle.
#[derive(Clone, Copy)]
pub(crate) struct CycleEnd<'a> {
    /// What the parts do.
    pub snapshot: &'a dyn Fn() -> Snapshot,
    /// What was counted up to now.
    pub tally: &'a dyn Fn() -> Tally,
}

/// Gives an engine the items that it replays, and is told what becomes of them.
pub(crate) trait Feed {
    /// The next item.
    fn next(&mut self) -> Result<Option<Item>, RunError>;

    /// A frame is over.
    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError>;

    /// Whether [`Feed::heard`] is to be called at the end of each cycle; the answer stays the same for a run.
    fn hears(&self) -> bool {
        false
    }

    /// Receives what the channels of the DRAM were asked for and given up to the end of the cycle, to be drained.
    fn heard(&mut self, _: &mut [&mut ChannelLog]) -> Result<(), RunError> {
        Ok(())
    }

    /// `rays` rays are done.
    fn rays_over(&mut self, _: usize) {}

    /// Whether a frame is over of which [`Feed::frame_counted`] is to be told.
    fn wants_frame(&self) -> bool {
        false
    }

    /// Receives what was counted up to the end of the cycle in which the frame was over.
    ///
    /// # Errors
    /// Whoever watches the run fails.
    fn frame_counted(&mut self, _: &Tally) -> Result<(), RunError> {
        Ok(())
    }

    /// Whether [`Feed::look_at`] may name a cycle; the answer stays the same for a run.
    fn looks(&self) -> bool {
        false
    }

    /// The next cycle at whose end [`Feed::looked`] is to be called; `u64::MAX` if none is known.
    fn look_at(&self) -> u64 {
        u64::MAX
    }

    /// Is shown the end of cycle `now`, in which all parts acted.
    ///
    /// # Errors
    /// Whoever watches the run fails, or the engine contradicts itself.
    fn looked(&mut self, _now: u64, _end: CycleEnd<'_>) -> Result<(), RunError> {
        Ok(())
    }

    /// Whether [`Feed::mark`] is to be called at the end of the cycle.
    fn marks(&self) -> bool {
        false
    }

    /// Receives a snapshot of all counters. Returns cache contents to load, at the first mark before anything is done,
    /// or `None`.
    ///
    /// Unlike a look, a mark is not known beforehand: accesses that `Event` made ahead are counted in it, of each unit
    /// those of as many cycles as an L2 takes at most.
    fn mark(&mut self, _: &Tally) -> Option<&WarmCaches> {
        None
    }
}
