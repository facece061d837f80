//! How a command ends, and its exit status.

use std::process::ExitCode;

use crate::experiment::run::RunFailure;
use crate::experiment::sweep::SweepError;
use crate::experiment::trace::TraceError;
use crate::replay::RunError;

/// The end of a command without an error.
pub(super) enum Outcome {
    /// Everything requested was done, and all checks hold.
    Done,
    /// Ctrl-C stopped the command, or a check does not hold.
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

/// The exit status of an error: 1 if the command was stopped or a simulation failed, 2 if the user can mend the cause.
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
