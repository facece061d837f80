//! Requests to the L2 and to the DRAM.

use crate::memory::dram::mapping::Place;
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// A request from a cache to the level below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub line: LineAddr,
    pub class: TrafficClass,
    pub write: bool,
    pub bytes: Bytes,
    /// The requester: an L1, a bank of the L2 or, after all banks, the host's port.
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
