//! How a command ends, and the exit status that says so.

use std::process::ExitCode;

use crate::experiment::run::RunFailure;
use crate::experiment::sweep::SweepError;
use crate::experiment::trace::TraceError;
use crate::replay::RunError;

/// How a command ended that met no error.
pub(super) enum Outcome {
    /// Everything asked for was done, and what must hold holds.
    Done,
    /// Ctrl-C stopped the command, or what must hold does not.
    Failed,
}

impl Outcome {
    pub(super) fn failed_if(failed: bool) -> Self {
        if failed { Self::Failed } else { Self::Done }
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::SUCCESS,
            Outcome::Failed => Self::from(1),
        }
    }
}

/// 1 for what was stopped or went wrong inside a simulation, 2 for what the user can mend.
pub(super) fn exit_code(error: &anyhow::Error) -> ExitCode {
    let replay_failed = error.downcast_ref::<RunError>().is_some_and(|error| {
        matches!(
            error,
            RunError::Counts { .. } | RunError::Invariant(_) | RunError::Illegal { .. } | RunError::Deadlock { .. }
        )
    });
    let stopped = matches!(error.downcast_ref(), Some(TraceError::Stopped))
        || matches!(
            error.downcast_ref(),
            Some(SweepError::Stopped | SweepError::Machine { .. } | SweepError::Missing { .. })
        );
    ExitCode::from(if replay_failed || stopped || error.is::<RunFailure>() { 1 } else { 2 })
}
