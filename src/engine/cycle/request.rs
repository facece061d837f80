//! What is asked of the L2 and of the DRAM.

use crate::memory::dram::mapping::Place;
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// What a cache asks of the level below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub line: LineAddr,
    pub class: TrafficClass,
    pub write: bool,
    pub bytes: Bytes,
    /// The L1, the bank of the L2 or, after all banks, the host's port that asks.
    pub from: usize,
}

/// A request in a channel of the DRAM.
#[derive(Clone, Copy, Debug)]
pub(super) struct DramRequest {
    pub request: Request,
    pub place: Place,
    pub activated: bool,
    pub precharged: bool,
    pub bursts_done: u64,
}
