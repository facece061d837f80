//! Why a run has no result.

use crate::replay::RunError;
use crate::report::ReportError;
use crate::stream::Totals;

/// Why a run ended without a result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunFailure {
    /// A machine failed.
    #[error("machine `{machine}` on the stream of `{policy}`")]
    Machine {
        /// The machine's name.
        machine: String,
        /// The policy's name.
        policy: String,
        /// What happened.
        source: Box<RunError>,
    },
    /// A stream's records do not match the tracer's counts: an error in the simulator.
    #[error("frame {frame}, policy `{policy}`: the stream holds {recorded:?}, the tracer counted {counted:?}")]
    Counts {
        /// The frame.
        frame: u32,
        /// The policy's name.
        policy: String,
        /// The counts from the records.
        recorded: Box<Totals>,
        /// The tracer's own counts.
        counted: Box<Totals>,
    },
    /// A picture of the report cannot be made: an error in the simulator.
    #[error(transparent)]
    Picture(#[from] ReportError),
    /// Stopped before the first frame was done.
    #[error("stopped before the first frame was done")]
    Stopped,
}
