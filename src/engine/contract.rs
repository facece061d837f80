//! The interface of every engine.

use super::error::RunError;
use super::feed::Feed;
use super::snapshot::Snapshot;
use super::tally::Tally;
use crate::memory::dram::command::ChannelLog;

/// A way of replaying a stream.
pub(crate) trait Engine {
    /// Replays all items of `feed`. Returns the number of cycles that the run took.
    ///
    /// # Errors
    /// The feed returns an error, the stream is wrong, or no part makes progress.
    fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError>;

    /// The counts of a run of `cycles` cycles.
    fn tally(&self, cycles: u64) -> Tally;

    /// State of the parts at the end of cycle `cycles - 1`; empty if the engine cannot be observed.
    fn snapshot(&self, _cycles: u64) -> Snapshot {
        Snapshot::default()
    }

    /// Logs of requests and commands, one per DRAM channel; empty if the engine's DRAM has no clock of its own.
    fn logs(&mut self) -> Vec<&mut ChannelLog>;
}
