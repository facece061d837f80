//! What an engine is fed with: the stream's items, all of them or a sample.

use super::error::RunError;
use super::source::FrameCounts;
use super::tally::Tally;
use super::warm::WarmCaches;
use crate::memory::dram::command::ChannelLog;
use crate::stream::Item;

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
    fn frame_counted(&mut self, _: &Tally) {}

    /// Whether [`Feed::mark`] is to be called at the end of the cycle.
    fn marks(&self) -> bool {
        false
    }

    /// Receives a snapshot of all counters. Returns cache contents to load, or `None`.
    fn mark(&mut self, _: &Tally) -> Option<&WarmCaches> {
        None
    }
}
