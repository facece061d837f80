//! The data bus of a flat channel, which moves a fixed number of bytes per cycle.

use super::link::Link;
use super::request::{DramRequest, Request};

pub(super) struct Bus {
    latency: u64,
    rate: Option<u64>,
    line: u64,
    /// The request whose line is being moved, and its remaining bytes.
    moving: Option<(Request, u64)>,
}

/// Transfers in a cycle.
pub(super) struct Moved {
    /// Requests whose transfer began.
    pub begun: Vec<Request>,
    /// Requests whose line has passed, each with the cycle in which it completes.
    pub passed: Vec<(u64, Request)>,
}

impl Bus {
    pub(super) fn new(latency: u64, rate: Option<u64>, line: u64) -> Self {
        Self { latency, rate, line, moving: None }
    }

    /// Moves lines in cycle `now`, as many bytes as the rate allows.
    pub(super) fn act(&mut self, now: u64, queue: &mut Link<DramRequest>) -> Moved {
        let (mut begun, mut passed) = (Vec::new(), Vec::new());
        let Some(mut bytes) = self.rate else {
            while let Some(entry) = queue.take(now) {
                begun.push(entry.request);
                passed.push((now + self.latency, entry.request));
            }
            return Moved { begun, passed };
        };
        while bytes > 0 {
            let next = || {
                let request = queue.take(now)?.request;
                begun.push(request);
                Some((request, self.line))
            };
            let Some((request, left)) = self.moving.take().or_else(next) else { break };
            let moved = bytes.min(left);
            bytes -= moved;
            if left > moved {
                self.moving = Some((request, left - moved));
            } else {
                passed.push((now + 1 + self.latency, request));
            }
        }
        Moved { begun, passed }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.moving.is_none()
    }
}
