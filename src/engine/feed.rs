//! What an engine is fed with: the stream's items, all of them or a sample.

use super::frame_log::FrameLog;
use super::sampling::WarmCaches;
use super::tally::Tally;
use super::{RunError, check};
use crate::engine::source::{FrameCounts, StoreWork};
use crate::machine::MachineSpec;
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

    /// So much was counted up to now. Gives what the caches are to hold from now on, if that is something else.
    fn mark(&mut self, _: &Tally) -> Option<&WarmCaches> {
        None
    }
}

/// All items.
pub(super) struct Whole<'a, I> {
    pub items: I,
    /// What is counted frame by frame.
    pub frames: FrameLog<'a>,
    /// What was done with stores otherwise than recorded.
    pub stores: StoreWork,
}

impl<'a, I> Whole<'a, I> {
    /// All of `items` for a machine.
    pub(super) fn new(machine: &'a MachineSpec, items: I) -> Self {
        Self { items, frames: FrameLog::new(machine), stores: StoreWork::default() }
    }
}

impl<E, I: Iterator<Item = Result<Item, E>>> Feed<E> for Whole<'_, I> {
    fn next(&mut self) -> Result<Option<Item>, RunError<E>> {
        self.items.next().transpose().map_err(RunError::Source)
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError<E>> {
        self.stores += counts.stores;
        self.frames.over(*counts);
        check::frame(counts, &self.frames.machine().shadow_cache)
    }

    fn wants_frame(&self) -> bool {
        self.frames.is_over()
    }

    fn frame_counted(&mut self, tally: &Tally) {
        self.frames.add(tally);
    }
}
