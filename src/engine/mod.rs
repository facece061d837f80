//! Replays a ray stream on a machine.

mod check;
mod event;
#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod tests;
mod wheel;

use crate::machine::dispatcher::{FrameCounts, StreamFault};
use crate::machine::{MachineSpec, SpecError};
use crate::stats::MachineStats;
use crate::stream::{Header, Item};

/// Why a run ended without a result. `E` is the error of who reads the stream.
#[derive(Debug, thiserror::Error)]
pub enum RunError<E> {
    /// The machine cannot be built.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The stream could not be read.
    #[error(transparent)]
    Source(E),
    /// The stream is wrong.
    #[error(transparent)]
    Stream(#[from] StreamFault),
    /// The machine replayed something else than the tracer recorded.
    #[error("frame {frame}: the machine replayed {machine} {what}, the tracer counted {tracer}")]
    Counts {
        /// The frame.
        frame: u32,
        /// What was counted.
        what: &'static str,
        /// The machine's count.
        machine: u64,
        /// The tracer's.
        tracer: u64,
    },
    /// An identity that holds for every run was violated: an error in the simulator.
    #[error("the run contradicts itself: {0}")]
    Invariant(String),
    /// Nothing moves.
    #[error("nothing has moved up to cycle {cycle}:\n{queues}")]
    Deadlock {
        /// When it was noticed.
        cycle: u64,
        /// All queues.
        queues: String,
    },
}

/// What an engine tells while it runs.
enum Outcome {
    FrameOver(FrameCounts),
}

/// Replays `items`, a stream with the given header, on a machine. Memory is bounded: a chunk is dropped when all its rays are
/// done. The run's identities (counts as the tracer's, conservation of bytes between levels, one cause for every cycle
/// of every unit) are checked, and a violation is an error.
pub fn run<E>(
    machine: &MachineSpec,
    header: &Header,
    items: impl Iterator<Item = Result<Item, E>>,
) -> Result<MachineStats, RunError<E>> {
    machine.check()?;
    replay(event::Event::new(machine, header), machine, items)
}

fn replay<E>(
    mut engine: event::Event,
    machine: &MachineSpec,
    mut items: impl Iterator<Item = Result<Item, E>>,
) -> Result<MachineStats, RunError<E>> {
    let next = || items.next().transpose().map_err(RunError::Source);
    let cycles = engine.run(next, |Outcome::FrameOver(counts)| check::frame(&counts))?;
    let stats = check::collect(&engine, machine, cycles);
    check::run(&engine, machine, &stats).map_err(RunError::Invariant)?;
    Ok(stats)
}
