//! Replays a ray stream on a machine.

mod check;
mod cycle;
mod event;
mod tally;
#[cfg(test)]
mod tests;
mod wheel;

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use self::tally::Tally;
use crate::machine::source::{FrameCounts, StoreWork, StreamFault};
use crate::machine::{MachineSpec, SpecError};
#[cfg(test)]
use crate::memory::dram::command::CommandLog;
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

/// How a machine is replayed. Both engines implement the rules of MODEL.md and give the same numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fidelity {
    /// A part acts only in cycles in which it has something to do: fast.
    #[default]
    Event,
    /// Every part acts in every cycle: plain, slow, and what `Event` is held to.
    Cycle,
}

impl Fidelity {
    /// Whether its numbers are those of [`Fidelity::Cycle`].
    pub fn is_exact(self) -> bool {
        matches!(self, Self::Event | Self::Cycle)
    }
}

/// The name in reports, as in files.
impl fmt::Display for Fidelity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Event => "Event",
            Self::Cycle => "Cycle",
        })
    }
}

impl FromStr for Fidelity {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        [Self::Event, Self::Cycle]
            .into_iter()
            .find(|fidelity| fidelity.to_string() == name)
            .ok_or_else(|| format!("there is no engine `{name}`: Event and Cycle are allowed"))
    }
}

/// A way of replaying a stream.
trait Engine {
    /// Replays all items that `next` gives; the number of cycles that it took. Every frame that is over is told.
    fn run<E>(
        &mut self,
        next: impl FnMut() -> Result<Option<Item>, RunError<E>>,
        frame_over: impl FnMut(&FrameCounts) -> Result<(), RunError<E>>,
    ) -> Result<u64, RunError<E>>;

    /// What was counted in a run of `cycles`.
    fn tally(&self, cycles: u64) -> Tally;

    #[cfg(test)]
    /// From now on the DRAM's commands are kept.
    fn keep_commands(&mut self);

    #[cfg(test)]
    /// The commands that were kept, a channel each.
    fn commands(&self) -> Vec<&CommandLog>;
}

/// Replays `items`, a stream with the given header, on a machine. Memory is bounded: a chunk is dropped when all its rays are
/// done. The run's identities (counts as the tracer's, conservation of bytes between levels, one cause for every cycle
/// of every unit) are checked, and a violation is an error.
pub fn run<E>(
    machine: &MachineSpec,
    fidelity: Fidelity,
    header: &Header,
    items: impl Iterator<Item = Result<Item, E>>,
) -> Result<MachineStats, RunError<E>> {
    machine.check()?;
    machine.check_stream(header)?;
    let tally = match fidelity {
        Fidelity::Event => replay(&mut event::Event::new(machine, header), machine, items)?,
        Fidelity::Cycle => replay(&mut cycle::Cycle::new(machine, header), machine, items)?,
    };
    Ok(tally.stats(machine))
}

fn replay<E>(
    engine: &mut impl Engine,
    machine: &MachineSpec,
    mut items: impl Iterator<Item = Result<Item, E>>,
) -> Result<Tally, RunError<E>> {
    let next = || items.next().transpose().map_err(RunError::Source);
    let mut stores = StoreWork::default();
    let cycles = engine.run(next, |counts| {
        stores += counts.stores;
        check::frame(counts, &machine.shadow_cache)
    })?;
    let tally = Tally { stores, ..engine.tally(cycles) };
    check::run(&tally, machine).map_err(RunError::Invariant)?;
    Ok(tally)
}

/// Cycles in which something must begin: more than any single wait of the machine, or two that follow one another, can take.
fn patience(spec: &MachineSpec) -> u64 {
    let caches = spec.l2.caches();
    let l2 = caches.iter().map(|(_, cache)| cache.latency.get());
    let units = [
        spec.dispatcher.latency.get(),
        spec.dispatcher.shading_cycles.get(),
        spec.traversal.latency.get(),
        spec.intersection.latency.get() + spec.intersection.divide_latency.get(),
        spec.shadow_cache.latency.get(),
        l2.max().unwrap_or(0),
    ];
    let part = &spec.dram.part;
    let clocks = part.timing.around_refresh(part.burst_clocks.get()) + part.timing.cl.get();
    100_000 + 2 * units.iter().sum::<u64>() + 2 * spec.dram.clocks(spec.clock_mhz.get()).cycle_after(clocks)
}
