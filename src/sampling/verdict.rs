//! The outcome of sampling.

use crate::engine::whole::whole;
use crate::engine::{Level, RunError, Source};
use crate::machine::MachineSpec;
use crate::stats::{Choice, MachineStats};
use crate::stream::Header;

/// The outcome of sampling a stream on a machine.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// The sample's estimates.
    Sampled(Box<MachineStats>),
    /// A sample does not pay: the whole stream is to be replayed.
    Whole {
        /// The level to replay it by.
        level: Level,
        /// What `Auto` did and why; `None` for other fidelities.
        choice: Option<Choice>,
    },
}

impl Verdict {
    /// The statistics of the sample, or of a replay of the whole stream.
    ///
    /// # Errors
    /// The stream cannot be read, or the replay fails.
    pub(crate) fn stats(
        self,
        machine: &MachineSpec,
        header: &Header,
        source: &dyn Source,
    ) -> Result<MachineStats, RunError> {
        match self {
            Self::Sampled(stats) => Ok(*stats),
            Self::Whole { level, choice } => {
                Ok(MachineStats { choice, ..whole(level, machine, header, &mut source.open(0)?, None)? })
            }
        }
    }
}
