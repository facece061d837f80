//! Why a run ended without a result.

use std::io;

use super::source::StreamFault;
use crate::machine::SpecError;
use crate::memory::dram::legality::Violation;
use crate::stream::StreamError;

/// Why a run ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The machine cannot be built.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The stream could not be read.
    #[error(transparent)]
    Source(#[from] StreamError),
    /// The stream is wrong.
    #[error(transparent)]
    Stream(#[from] StreamFault),
    /// The machine replayed something other than what the tracer recorded.
    #[error("frame {frame}: the machine replayed {machine} {what}, the tracer counted {tracer}")]
    Counts {
        /// The frame.
        frame: u32,
        /// The name of the count.
        what: &'static str,
        /// The machine's count.
        machine: u64,
        /// The tracer's count.
        tracer: u64,
    },
    /// An identity that holds for every run was violated: an error in the simulator.
    #[error("the run contradicts itself: {0}")]
    Invariant(String),
    /// The DRAM was given a command that its part forbids: an error in the simulator.
    #[error("channel {channel} of the DRAM, {violation}")]
    Illegal {
        /// The channel.
        channel: usize,
        /// The violated rule.
        violation: Violation,
    },
    /// The observer of the run failed.
    #[error(transparent)]
    Observer(io::Error),
    /// The sample has too few windows.
    #[error(
        "a sample of {rate} of the stream's {windows} windows of {pixels} pixels is too small to tell anything: \
         {advice}"
    )]
    Sample {
        /// Windows of the stream.
        windows: usize,
        /// Pixels of a window.
        pixels: usize,
        /// The share of windows that was requested.
        rate: f64,
        /// What to change.
        advice: String,
    },
    /// No part makes progress.
    #[error("nothing has moved up to cycle {cycle}:\n{queues}")]
    Deadlock {
        /// The cycle in which the watchdog noticed it.
        cycle: u64,
        /// The state of all queues.
        queues: String,
    },
}
