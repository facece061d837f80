//! The memory below the L1s, as far as units know it.

use crate::machine::MachineSpec;

/// What a unit knows of the memory below its L1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Memory {
    /// Bytes of a line.
    pub line: u64,
    /// The shortest latency of a cache of the L2.
    pub answer_latency: u64,
}

impl Memory {
    /// Of `machine`.
    pub(crate) fn new(machine: &MachineSpec) -> Self {
        let latencies = machine.l2.caches().into_iter().map(|(_, cache)| cache.latency.get());
        Self { line: machine.line_bytes.get(), answer_latency: latencies.min().unwrap_or(0) }
    }
}
