//! DRAM: channels with bank groups, banks, open rows and refresh, or flat channels.

mod channel;
pub(crate) mod command;
pub mod currents;
mod flat;
pub(crate) mod legality;
pub mod mapping;
pub mod part;
pub mod power;
pub mod spec;
#[cfg(test)]
mod tests;

use self::command::ChannelLog;
use self::spec::{Clocks, DramSpec, Model};
use super::queue::Load;
use super::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{DramCounts, TrafficClass};

/// All channels; they use the same model.
#[derive(Clone, Debug)]
enum Channels {
    Banks(Vec<channel::Channel>),
    Flat(Vec<flat::Channel>),
}

/// All channels of a DRAM.
#[derive(Clone, Debug)]
pub struct Dram {
    spec: DramSpec,
    clocks: Clocks,
    channels: Channels,
}

impl Dram {
    /// An idle DRAM; its channels' numbers in the machine begin with `first`.
    pub fn new(spec: &DramSpec, machine_mhz: u64, line: u64, first: PartId) -> Self {
        let clocks = spec.clocks(machine_mhz);
        let parts = (0..spec.channels.get()).map(|index| PartId(first.0 + index as u32));
        let channels = match spec.model {
            Model::Banks => {
                Channels::Banks(parts.map(|part| channel::Channel::new(spec, clocks, line, part)).collect())
            }
            Model::Flat { latency, bytes_per_cycle } => {
                let rate = bytes_per_cycle.map(|bytes| bytes.get());
                let channel = |part| flat::Channel::new(spec.queue.size(), latency.get(), rate, line, part);
                Channels::Flat(parts.map(channel).collect())
            }
        };
        Self { spec: spec.clone(), clocks, channels }
    }

    /// Puts a request into its channel's queue in cycle `now`. Without a place, it returns false and wakes the
    /// requester later.
    pub fn put(&mut self, request: Request, now: u64, wake: &mut impl Wake) -> bool {
        let place = self.spec.place(request.line);
        match &mut self.channels {
            Channels::Banks(channels) => channels[place.channel].put(request, place, now, wake),
            Channels::Flat(channels) => channels[place.channel].put(request, now, wake),
        }
    }

    /// Simulates cycle `now` of channel `index`. `answer` sends a line to the L2 bank that requested it.
    pub fn tick(&mut self, index: usize, now: u64, wake: &mut impl Wake, answer: impl FnMut(PartId, LineAddr)) {
        match &mut self.channels {
            Channels::Banks(channels) => channels[index].tick(now, wake, answer),
            Channels::Flat(channels) => channels[index].tick(now, wake, answer),
        }
    }

    /// The number of channels.
    pub fn channels(&self) -> usize {
        self.spec.channels.size()
    }

    /// Whether no request or transfer is pending.
    pub fn is_idle(&self) -> bool {
        match &self.channels {
            Channels::Banks(channels) => channels.iter().all(channel::Channel::is_idle),
            Channels::Flat(channels) => channels.iter().all(flat::Channel::is_idle),
        }
    }

    /// Whether a refresh of channel `index` that was due in a clock up to cycle `now` has not been given.
    pub fn refresh_is_due(&self, index: usize, now: u64) -> bool {
        match &self.channels {
            Channels::Banks(channels) => self.clocks.cycle(channels[index].refresh_due()) <= now,
            Channels::Flat(_) => false,
        }
    }

    /// The counts of channel `index`: commands and requests; a flat channel counts reads and writes only.
    pub fn counts(&self, index: usize) -> &DramCounts {
        match &self.channels {
            Channels::Banks(channels) => channels[index].counts(),
            Channels::Flat(channels) => channels[index].counts(),
        }
    }

    /// Bytes that channel `index` moved, by class.
    pub fn moved(&self, index: usize) -> &[Bytes; TrafficClass::ALL.len()] {
        match &self.channels {
            Channels::Banks(channels) => channels[index].moved(),
            Channels::Flat(channels) => channels[index].moved(),
        }
    }

    /// The logs of requests and commands, per channel; flat channels have none.
    pub fn logs(&mut self) -> Vec<&mut ChannelLog> {
        match &mut self.channels {
            Channels::Banks(channels) => channels.iter_mut().map(channel::Channel::log).collect(),
            Channels::Flat(_) => Vec::new(),
        }
    }

    /// Requests in the queue of channel `index`.
    pub fn waiting(&self, index: usize) -> usize {
        match &self.channels {
            Channels::Banks(channels) => channels[index].waiting(),
            Channels::Flat(channels) => channels[index].waiting(),
        }
    }

    /// Load of the queue of channel `index`.
    pub fn load(&self, index: usize) -> Load {
        match &self.channels {
            Channels::Banks(channels) => channels[index].load(),
            Channels::Flat(channels) => channels[index].load(),
        }
    }

    /// The state of the queue of channel `index`, for the report of a deadlock.
    pub fn queues(&self, index: usize) -> String {
        match &self.channels {
            Channels::Banks(channels) => channels[index].queues(),
            Channels::Flat(channels) => channels[index].queues(),
        }
    }
}
