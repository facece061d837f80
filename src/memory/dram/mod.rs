//! DRAM: channels with bank groups, banks, open rows and refresh.

mod channel;
pub mod command;
pub mod legality;
pub mod mapping;
pub mod part;
pub mod spec;
#[cfg(test)]
mod tests;

use self::channel::Channel;
use self::command::CommandLog;
use self::spec::{Clocks, DramSpec};
use super::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{DramCounts, TrafficClass};

/// All channels of a DRAM.
#[derive(Clone, Debug)]
pub struct Dram {
    spec: DramSpec,
    clocks: Clocks,
    channels: Vec<Channel>,
}

impl Dram {
    /// An idle DRAM; its channels' numbers in the machine begin with `first`.
    pub fn new(spec: &DramSpec, machine_mhz: u64, line: u64, first: PartId) -> Self {
        let clocks = spec.clocks(machine_mhz);
        let channel = |index: u64| Channel::new(spec, clocks, line, PartId(first.0 + index as u32));
        Self { spec: spec.clone(), clocks, channels: (0..spec.channels.get()).map(channel).collect() }
    }

    /// Puts a request into its channel's queue in cycle `now`; without a place, the asker is woken when there is one.
    pub fn put(&mut self, request: Request, now: u64, wake: &mut impl Wake) -> bool {
        let place = self.spec.place(request.line);
        self.channels[place.channel].put(request, place, now, wake)
    }

    /// Cycle `now` of channel `index`. `answer` hands a line to the bank of the L2 that asked for it.
    pub fn tick(&mut self, index: usize, now: u64, wake: &mut impl Wake, answer: impl FnMut(PartId, LineAddr)) {
        self.channels[index].tick(now, wake, answer);
    }

    /// The number of channels.
    pub fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Whether nothing is under way.
    pub fn is_idle(&self) -> bool {
        self.channels.iter().all(Channel::is_idle)
    }

    /// Whether a refresh of channel `index` was due in a clock that began in cycle `now` or before, and was not given.
    pub fn refresh_is_due(&self, index: usize, now: u64) -> bool {
        self.clocks.cycle(self.channels[index].refresh_due()) <= now
    }

    /// The commands of channel `index`.
    pub fn counts(&self, index: usize) -> &DramCounts {
        self.channels[index].counts()
    }

    /// Bytes that channel `index` moved, by class.
    pub fn moved(&self, index: usize) -> &[Bytes; TrafficClass::ALL.len()] {
        self.channels[index].moved()
    }

    /// From now on all commands are kept.
    pub fn keep_commands(&mut self) {
        self.channels.iter_mut().for_each(Channel::keep_commands);
    }

    /// The commands of channel `index`, as far as they were kept.
    pub fn log(&self, index: usize) -> &CommandLog {
        self.channels[index].log()
    }

    /// The state of the queue of channel `index`, for the report of a deadlock.
    pub fn queues(&self, index: usize) -> String {
        self.channels[index].queues()
    }
}
