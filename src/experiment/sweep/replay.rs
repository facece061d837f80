//! A recorded stream replayed on a machine, unless it is stopped.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::SweepError;
use super::streams::Recorded;
use crate::machine::MachineSpec;
use crate::replay::{Fidelity, Items, Replay, RunError, Source, StreamFile};
use crate::stats::MachineStats;
use crate::stream::StreamError;

/// A recorded stream that ends as one that is cut off does when it is stopped: the replay is thrown away.
struct Stoppable<'a> {
    file: StreamFile<'a>,
    stop: &'a AtomicBool,
}

impl Source for Stoppable<'_> {
    fn open(&self, frame: usize) -> Result<Items<'_>, StreamError> {
        Ok(Box::new(self.file.open(frame)?.take_while(|_| !self.stop.load(Ordering::Relaxed))))
    }
}

/// Replays a recorded stream on a machine.
///
/// # Errors
/// The replay is stopped or fails.
pub(crate) fn replay(
    machine: &MachineSpec,
    fidelity: Fidelity,
    stream: &Recorded,
    stop: &AtomicBool,
) -> Result<MachineStats, SweepError> {
    let source = Stoppable { file: StreamFile(&stream.path), stop };
    let replay = Replay::new(machine, &stream.header).map_err(RunError::from);
    let stats = replay.and_then(|replay| replay.fidelity(fidelity).run(&source));
    if stop.load(Ordering::Relaxed) {
        return Err(SweepError::Stopped);
    }
    stats.map_err(|source| SweepError::Machine {
        machine: machine.name.clone(),
        policy: stream.header.policy.clone(),
        source: Box::new(source),
    })
}
