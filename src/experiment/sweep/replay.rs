//! A recorded stream replayed on a machine, unless it is stopped.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::SweepError;
use super::streams::Recorded;
use crate::machine::MachineSpec;
use crate::replay::{Cut, Demand, Fidelity, Items, Replay, RunError, Source, StreamFile};
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

/// Replays a recorded stream on a machine; samples are cut as is said, or as the machine asks for.
///
/// # Errors
/// The replay is stopped or fails.
pub(crate) fn replay(
    machine: &MachineSpec,
    (fidelity, cut): (Fidelity, Option<Cut>),
    stream: &Recorded,
    stop: &AtomicBool,
) -> Result<MachineStats, SweepError> {
    let replay = replay_of(machine, stream).map(|replay| cut.map_or(replay, |cut| replay.cut(cut)));
    let replayed = replay.and_then(|replay| replay.fidelity(fidelity).run(&source(stream, stop)));
    told(replayed, machine, stream, stop)
}

/// What a recorded stream asks of machines like `machine`.
///
/// # Errors
/// The pass is stopped or fails.
pub(in super::super) fn demand(
    machine: &MachineSpec,
    stream: &Recorded,
    stop: &AtomicBool,
) -> Result<Demand, SweepError> {
    let demand = replay_of(machine, stream).and_then(|replay| replay.demand(&source(stream, stop)));
    told(demand, machine, stream, stop)
}

fn source<'a>(stream: &'a Recorded, stop: &'a AtomicBool) -> Stoppable<'a> {
    Stoppable { file: StreamFile(&stream.path), stop }
}

fn replay_of<'a>(machine: &'a MachineSpec, stream: &'a Recorded) -> Result<Replay<'a>, RunError> {
    Ok(Replay::new(machine, &stream.header)?)
}

fn told<T>(
    result: Result<T, RunError>,
    machine: &MachineSpec,
    stream: &Recorded,
    stop: &AtomicBool,
) -> Result<T, SweepError> {
    if stop.load(Ordering::Relaxed) {
        return Err(SweepError::Stopped);
    }
    result.map_err(|source| SweepError::Machine {
        machine: machine.name.clone(),
        policy: stream.header.policy.clone(),
        source: Box::new(source),
    })
}
