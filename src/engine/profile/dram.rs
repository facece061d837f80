//! DRAM channels whose banks and bus have times from which they are free. Requests to a bank are served in arrival
//! order, except requests to a row that has not been left yet.

use super::slots::Slots;
use crate::engine::tally::{ChannelTally, PerClass};
use crate::memory::dram::mapping::Place;
use crate::memory::dram::part::DramPart;
use crate::memory::dram::spec::{Clocks, DramSpec, Model, Page};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{DramCounts, TrafficClass};

/// A bank of the DRAM; times are clocks of the DRAM.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    open: Option<u64>,
    /// The row that was open before; it can still be read up to this clock.
    before: Option<u64>,
    leaves_at: u64,
    /// The earliest clocks of a column command, a precharge and an activate.
    column_at: u64,
    precharge_at: u64,
    activate_at: u64,
}

#[derive(Clone, Debug)]
struct Channel {
    rows: Vec<Row>,
    /// The data bus. `written`, `read`: the clock of the last column command of this kind, and the end of its data.
    bus: Slots,
    written: (u64, u64),
    read: (u64, u64),
    activates: Slots,
    /// Number of refreshes so far.
    refreshed: u64,
    settled_at: u64,
    counts: DramCounts,
    moved: PerClass<Bytes>,
}

/// All channels.
#[derive(Clone, Debug)]
pub(super) struct Dram {
    spec: DramSpec,
    clocks: Clocks,
    line: Bytes,
    /// Clocks of a line on the bus; for a flat channel, bytes.
    transfer: u64,
    channels: Vec<Channel>,
}

impl Dram {
    /// The idle DRAM of a machine of `machine_mhz` with lines of `line` bytes.
    pub(super) fn new(spec: &DramSpec, machine_mhz: u64, line: u64) -> Self {
        let DramPart { timing, banks, burst_clocks, .. } = &spec.part;
        // The bus time of a flat channel is in bytes: a cycle has as many bytes as the bus moves in it.
        let transfer = match spec.model {
            Model::Banks => spec.part.bursts(line) * burst_clocks.get(),
            Model::Flat { .. } => line,
        };
        let channel = Channel {
            rows: vec![Row::default(); banks.size()],
            bus: Slots::new(transfer),
            written: (0, 0),
            read: (0, 0),
            activates: Slots::new(timing.rrd_s.get().max(timing.faw.get().div_ceil(4))),
            refreshed: 0,
            settled_at: 0,
            counts: DramCounts::default(),
            moved: PerClass::default(),
        };
        Self {
            clocks: spec.clocks(machine_mhz),
            line: Bytes(line),
            transfer,
            channels: vec![channel; spec.channels.size()],
            spec: spec.clone(),
        }
    }

    /// Serves a request put in cycle `at`; returns the cycle in which its data has passed.
    pub(super) fn request(&mut self, line: LineAddr, class: TrafficClass, write: bool, at: u64) -> u64 {
        let Place { channel, bank, row, .. } = self.spec.place(line);
        let timing = &self.spec.part.timing;
        let channel = &mut self.channels[channel];
        channel.moved[class as usize] += self.line;
        if let Model::Flat { latency, bytes_per_cycle } = self.spec.model {
            *(if write { &mut channel.counts.writes } else { &mut channel.counts.reads }) += 1;
            let passed = bytes_per_cycle
                .map_or(at + 1, |rate| (channel.bus.take((at + 1) * rate.get()) + self.transfer).div_ceil(rate.get()));
            channel.settled_at = channel.settled_at.max(passed + latency.get());
            return passed + latency.get();
        }
        let mut clock = self.clocks.first(at + 1);
        let due = clock / timing.refi.get();
        if due > channel.refreshed {
            // All rows are closed, and no command is legal before the refresh is over.
            channel.refreshed = due;
            let over = due * timing.refi.get() + timing.rp.get() + timing.rfc.get();
            for row in &mut channel.rows {
                (row.open, row.before, row.activate_at) = (None, None, row.activate_at.max(over));
            }
        }
        let place = &mut channel.rows[bank];
        match place.open {
            Some(open) if open == row => {
                channel.counts.row_hits += 1;
                clock = clock.max(place.column_at);
            }
            _ if place.before == Some(row) && clock < place.leaves_at => channel.counts.row_hits += 1,
            open => {
                (place.before, place.leaves_at) = (open, clock.max(place.precharge_at));
                if open.is_some() {
                    channel.counts.row_conflicts += 1;
                    clock = clock.max(place.precharge_at) + timing.rp.get();
                } else {
                    channel.counts.row_misses += 1;
                }
                channel.counts.activates += 1;
                clock = clock.max(place.activate_at);
                clock = channel.activates.take(clock);
                (place.open, place.activate_at) = (Some(row), clock + timing.rc.get());
                place.precharge_at = clock + timing.ras.get();
                clock += timing.rcd.get();
            }
        }
        // The bus turns between reads and writes. A command before the last command of the other direction does not
        // wait for that.
        let (latency, (other, turned)) = if write {
            let (read, end) = channel.read;
            (timing.cwl.get(), (read, (end + timing.turn.get()).saturating_sub(timing.cwl.get())))
        } else {
            let (written, end) = channel.written;
            let turned = if end > 0 { end + timing.wtr_l.get() } else { 0 };
            (timing.cl.get(), (written, turned))
        };
        if clock >= other {
            clock = clock.max(turned);
        }
        clock = channel.bus.take(clock + latency) - latency;
        let end = clock + latency + self.transfer;
        let (counted, last, recovered) = if write {
            (&mut channel.counts.writes, &mut channel.written, end + timing.wr.get())
        } else {
            (&mut channel.counts.reads, &mut channel.read, clock + timing.rtp.get())
        };
        *last = (*last).max((clock, end));
        *counted += 1;
        place.column_at = place.column_at.max(clock);
        place.precharge_at = place.precharge_at.max(recovered);
        if self.spec.page == Page::Closed {
            place.open = None;
            place.activate_at = place.activate_at.max(place.precharge_at + timing.rp.get());
        }
        channel.settled_at = channel.settled_at.max(end);
        self.clocks.cycle_after(end)
    }

    /// The cycle in which all pending work ends.
    pub(super) fn settled_at(&self) -> u64 {
        let last = self.channels.iter().map(|channel| channel.settled_at).max().unwrap_or(0);
        match self.spec.model {
            Model::Banks => self.clocks.cycle_after(last),
            Model::Flat { .. } => last,
        }
    }

    /// The channels' counts in a run of `cycles`.
    pub(super) fn tally(&self, cycles: u64) -> Vec<ChannelTally> {
        let refreshes = match self.spec.model {
            Model::Banks => (self.clocks.first(cycles) - 1) / self.spec.part.timing.refi.get(),
            Model::Flat { .. } => 0,
        };
        let tally = |channel: &Channel| ChannelTally {
            counts: DramCounts { refreshes, ..channel.counts },
            moved: channel.moved,
            refresh_due: false,
        };
        self.channels.iter().map(tally).collect()
    }
}
