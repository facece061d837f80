//! A flat channel: a data bus that moves one line after another, and a fixed latency.

use std::collections::VecDeque;

use crate::memory::queue::{Load, Queue};
use crate::memory::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{DramCounts, TrafficClass};

/// One channel.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    part: PartId,
    latency: u64,
    /// Bytes that the bus moves per cycle; `None`: transfers take no time.
    rate: Option<u64>,
    line: u64,
    queue: Queue<Request>,
    /// When the bus is free, in units of the time to move one byte.
    bus_free: u64,
    /// Requests whose transfer has begun, each with the cycle in which it completes.
    transfers: VecDeque<(u64, Request)>,
    counts: DramCounts,
    moved: [Bytes; TrafficClass::ALL.len()],
}

impl Channel {
    /// An idle channel with the number `part` in the machine, for lines of `line` bytes.
    pub(super) fn new(queue: usize, latency: u64, rate: Option<u64>, line: u64, part: PartId) -> Self {
        Self {
            part,
            latency,
            rate,
            line,
            queue: Queue::new(queue),
            bus_free: 0,
            transfers: VecDeque::new(),
            counts: DramCounts::default(),
            moved: [Bytes(0); TrafficClass::ALL.len()],
        }
    }

    /// Puts a request into the queue in cycle `now`. Without a place, it returns false and wakes the requester later.
    pub(super) fn put(&mut self, request: Request, now: u64, wake: &mut impl Wake) -> bool {
        if !self.queue.has_room(now) {
            self.queue.wait_for_room(request.from, now, wake);
            return false;
        }
        self.queue.put(request, now + 1);
        wake.wake(self.part, now + 1);
        true
    }

    /// Simulates cycle `now`. `answer` sends a line to the L2 bank that requested it.
    pub(super) fn tick(&mut self, now: u64, wake: &mut impl Wake, mut answer: impl FnMut(PartId, LineAddr)) {
        while let Some(&(_, request)) = self.transfers.front().filter(|&&(at, _)| at <= now) {
            self.transfers.pop_front();
            if !request.write {
                answer(request.from, request.line);
                wake.wake(request.from, now + 1);
            }
        }
        while let Some(ends) = self.transfer_ends(now)
            && let Some(request) = self.queue.take(now, wake)
        {
            self.bus_free = ends;
            *(if request.write { &mut self.counts.writes } else { &mut self.counts.reads }) += 1;
            self.moved[request.class as usize] += request.bytes;
            let passed = self.rate.map_or(now, |rate| ends.div_ceil(rate));
            self.transfers.push_back((passed + self.latency, request));
        }
        let bus_free = self.rate.map_or(0, |rate| self.bus_free / rate);
        let next = self.queue.next_at().map(|at| at.max(bus_free).max(now + 1));
        let over = self.transfers.front().map(|transfer| transfer.0);
        next.into_iter().chain(over).for_each(|at| wake.wake(self.part, at));
    }

    /// The end, in bus time, of a transfer that begins in cycle `now`; `None` if the bus is busy all cycle.
    fn transfer_ends(&self, now: u64) -> Option<u64> {
        let Some(rate) = self.rate else { return Some(0) };
        (self.bus_free < (now + 1) * rate).then(|| self.bus_free.max(now * rate) + self.line)
    }

    /// Whether no request or transfer is pending.
    pub(super) fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.transfers.is_empty()
    }

    /// Counts of requests.
    pub(super) fn counts(&self) -> &DramCounts {
        &self.counts
    }

    /// Bytes moved, by class.
    pub(super) fn moved(&self) -> &[Bytes; TrafficClass::ALL.len()] {
        &self.moved
    }

    /// Requests in the queue.
    pub(super) fn waiting(&self) -> usize {
        self.queue.len()
    }

    /// Load of the queue.
    pub(super) fn load(&self) -> Load {
        self.queue.load()
    }

    /// The state of the queue, for the report of a deadlock.
    pub(super) fn queues(&self) -> String {
        format!("queue {}/{}, transfers {}", self.queue.len(), self.queue.capacity(), self.transfers.len())
    }
}
