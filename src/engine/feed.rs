//! The input of an engine: it supplies a stream's items, all of them or a sample, and receives the engine's counts.

use super::error::RunError;
use super::snapshot::Snapshot;
use super::source::FrameCounts;
use super::tally::Tally;
use super::warm::WarmCaches;
use crate::memory::dram::command::ChannelLog;
use crate::stream::Item;

/// Access to an engine's state at the end of a cycle.
#[derive(Clone, Copy)]
pub(crate) struct CycleEnd<'a> {
    /// Computes the state of the parts.
    pub snapshot: &'a dyn Fn() -> Snapshot,
    /// Computes the counts of the run so far.
    pub tally: &'a dyn Fn() -> Tally,
}

/// Supplies the items that an engine replays, and receives what the engine reports.
pub(crate) trait Feed {
    /// The next item; `None` at the stream's end.
    fn next(&mut self) -> Result<Option<Item>, RunError>;

    /// A frame is over: receives its counts.
    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError>;

    /// Whether [`Feed::heard`] is to be called at the end of each cycle; constant during a run.
    fn hears(&self) -> bool {
        false
    }

    /// Receives the logs of all DRAM channels up to the end of the cycle, and drains them.
    fn heard(&mut self, _: &mut [&mut ChannelLog]) -> Result<(), RunError> {
        Ok(())
    }

    /// `rays` more rays are done.
    fn rays_over(&mut self, _: usize) {}

    /// Whether a frame is over for which [`Feed::frame_counted`] is still to be called.
    fn wants_frame(&self) -> bool {
        false
    }

    /// Receives the run's counts up to the end of the cycle in which the frame was over.
    ///
    /// # Errors
    /// The observer of the run fails.
    fn frame_counted(&mut self, _: &Tally) -> Result<(), RunError> {
        Ok(())
    }

    /// Whether [`Feed::look_at`] may name a cycle; constant during a run.
    fn looks(&self) -> bool {
        false
    }

    /// The next cycle at whose end [`Feed::looked`] is to be called; `u64::MAX` if none is known.
    fn look_at(&self) -> u64 {
        u64::MAX
    }

    /// Receives access to the state at the end of cycle `now`, after all parts have acted.
    ///
    /// # Errors
    /// The observer of the run fails, or the engine contradicts itself.
    fn looked(&mut self, _now: u64, _end: CycleEnd<'_>) -> Result<(), RunError> {
        Ok(())
    }

    /// Whether [`Feed::mark`] is to be called at the end of the cycle.
    fn marks(&self) -> bool {
        false
    }

    /// Receives a snapshot of all counters. Returns cache contents to load, or `None`. Contents can be loaded only at
    /// the first mark, before any work is done.
    ///
    /// Unlike the cycles of [`Feed::look_at`], a mark is not known in advance. Its counts therefore include accesses
    /// that `Event` has made ahead, for each unit over at most the shortest L2 latency.
    fn mark(&mut self, _: &Tally) -> Option<&WarmCaches> {
        None
    }
}
