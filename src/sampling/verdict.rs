//! What sampling ends with.

use crate::engine::whole::whole;
use crate::engine::{Level, RunError, Source};
use crate::machine::MachineSpec;
use crate::stats::{Choice, MachineStats};
use crate::stream::Header;

/// What sampling of a stream on a machine ends with.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// What a sample tells.
    Sampled(Box<MachineStats>),
    /// A sample does not pay: everything is to be replayed.
    Whole {
        /// By this level.
        level: Level,
        /// Why, if it was to be told.
        choice: Option<Choice>,
    },
}

impl Verdict {
    /// The statistics: those of the sample, or of a replay of everything.
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
