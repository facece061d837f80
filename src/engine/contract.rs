//! What every engine does.

use super::error::RunError;
use super::feed::Feed;
use super::snapshot::Snapshot;
use super::tally::Tally;
use crate::memory::dram::command::ChannelLog;

/// A way of replaying a stream.
pub(crate) trait Engine {
    /// Replays all items of `feed`; returns the number of cycles that the run took.
    ///
    /// # Errors
    /// The feed refuses something, the stream is wrong, or nothing moves.
    fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError>;

    /// What was counted in a run of `cycles`.
    fn tally(&self, cycles: u64) -> Tally;

    /// What the parts do at the end of the cycle before `cycles`; nothing of an engine that is not looked at.
    fn snapshot(&self, _cycles: u64) -> Snapshot {
        Snapshot::default()
    }

    /// Requests and commands of each channel of the DRAM; none of an engine whose DRAM has no clock of its own.
    fn logs(&mut self) -> Vec<&mut ChannelLog>;
}
