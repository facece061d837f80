//! A channel of the DRAM: stores when each command was last given, and checks in each clock which commands are legal.

use std::collections::VecDeque;

use super::flat::{Bus, Moved};
use super::request::{DramRequest, Request};
use super::wires::Wires;
use crate::memory::dram::command::{ChannelLog, Column, Command};
use crate::memory::dram::part::DramPart;
use crate::memory::dram::spec::{DramSpec, Model, Page};
use crate::quantity::Bytes;
use crate::stats::{DramCounts, TrafficClass};

/// The last events in a bank, in clocks of the DRAM.
#[derive(Clone, Debug, Default)]
struct BankState {
    open: Option<u64>,
    activate: Option<u64>,
    precharge: Option<u64>,
    read: Option<u64>,
    write_data_end: Option<u64>,
    /// The bank closes by itself as soon as it may; requests see it as closed.
    closes_itself: bool,
}

/// The last events in a bank group.
#[derive(Clone, Debug, Default)]
struct GroupState {
    activate: Option<u64>,
    column: Option<u64>,
    write_data_end: Option<u64>,
}

pub(super) struct Channel {
    index: usize,
    part: DramPart,
    page: Page,
    /// The data bus of a flat channel, whose clock is the machine's.
    flat: Option<Bus>,
    mhz: u64,
    machine_mhz: u64,
    bursts: u64,
    /// The next clock to simulate.
    clock: u64,
    banks: Vec<BankState>,
    groups: Vec<GroupState>,
    /// Activates in the last tFAW clocks.
    activates: Vec<u64>,
    refresh: Option<u64>,
    /// The first clock in which the data bus is free.
    bus_free: u64,
    /// Whether the last burst on the bus was written.
    bus_writes: bool,
    /// Requests with the clock in which their data ends.
    transfers: VecDeque<(u64, Request)>,
    pub counts: DramCounts,
    pub moved: [Bytes; TrafficClass::ALL.len()],
    log: ChannelLog,
}

/// Whether at least `wait` clocks have passed between an event, if there was one, and clock `now`.
fn passed(event: Option<u64>, wait: u64, now: u64) -> bool {
    event.is_none_or(|event| now >= event + wait)
}

impl Channel {
    pub(super) fn new(spec: &DramSpec, index: usize, machine_mhz: u64, line: u64) -> Self {
        let part = spec.part.clone();
        let (flat, mhz) = match spec.model {
            Model::Banks => (None, part.clock_mhz.get()),
            Model::Flat { latency, bytes_per_cycle } => {
                (Some(Bus::new(latency.get(), bytes_per_cycle.map(|bytes| bytes.get()), line)), machine_mhz)
            }
        };
        Self {
            index,
            page: spec.page,
            flat,
            mhz,
            machine_mhz,
            bursts: line / part.burst_bytes.get(),
            clock: 0,
            banks: vec![BankState::default(); part.banks.size()],
            groups: vec![GroupState::default(); part.bank_groups.size()],
            activates: Vec::new(),
            refresh: None,
            bus_free: 0,
            bus_writes: true,
            transfers: VecDeque::new(),
            counts: DramCounts::default(),
            moved: Default::default(),
            log: ChannelLog::default(),
            part,
        }
    }

    pub(super) fn tick(&mut self, cycle: u64, wires: &mut Wires) {
        let mhz = self.mhz;
        // Data that ends at clock `e` has passed when `e / mhz` is not after the beginning of the cycle.
        while let Some(&(end, request)) = self.transfers.front()
            && end * self.machine_mhz <= cycle * mhz
        {
            self.transfers.pop_front();
            // The host's port has an index after all banks: its lines need no answer.
            if !request.write
                && let Some(bank) = wires.from_dram.get_mut(request.from)
            {
                bank.put(cycle, request.line);
            }
        }
        if self.log.is_kept() {
            // A request put in the last cycle came before the first clock that begins in this cycle or later.
            let came = wires.to_channel[self.index].came(cycle).map(|entry| entry.request);
            came.for_each(|request| self.log.put(self.clock - 1, request.line, request.write));
        }
        // Clocks that begin before the cycle ends.
        while self.clock * self.machine_mhz < (cycle + 1) * mhz {
            self.act(self.clock, cycle, wires);
            self.clock += 1;
        }
    }

    fn act(&mut self, now: u64, cycle: u64, wires: &mut Wires) {
        if let Some(bus) = &mut self.flat {
            let Moved { begun, passed } = bus.act(now, &mut wires.to_channel[self.index]);
            begun.iter().for_each(|request| self.count(request));
            self.transfers.extend(passed);
            return;
        }
        for number in 0..self.banks.len() {
            if self.banks[number].closes_itself && self.can_precharge(&self.banks[number], now) {
                (self.banks[number].closes_itself, self.banks[number].precharge) = (false, Some(now));
            }
        }
        if now >= (self.counts.refreshes + 1) * self.part.timing.refi.get() {
            self.toward_refresh(now);
        } else {
            self.serve(now, cycle, wires);
        }
    }

    /// Whether a refresh that was due by the last simulated clock has not been given.
    pub(super) fn refresh_is_due(&self) -> bool {
        self.flat.is_none() && self.clock > (self.counts.refreshes + 1) * self.part.timing.refi.get()
    }

    fn toward_refresh(&mut self, now: u64) {
        if self.banks.iter().all(|bank| bank.open.is_none()) {
            if self.banks.iter().all(|bank| self.bank_can_activate(bank, now)) {
                self.refresh = Some(now);
                self.counts.refreshes += 1;
                self.log.give(now, Command::Refresh);
            }
        } else if self.banks.iter().all(|bank| bank.open.is_none() || self.can_precharge(bank, now)) {
            for bank in self.banks.iter_mut().filter(|bank| bank.open.is_some()) {
                (bank.open, bank.precharge) = (None, Some(now));
            }
            self.log.give(now, Command::PrechargeAll);
        }
    }

    fn bank_can_activate(&self, bank: &BankState, now: u64) -> bool {
        !bank.closes_itself
            && passed(bank.activate, self.part.timing.rc.get(), now)
            && passed(bank.precharge, self.part.timing.rp.get(), now)
            && passed(self.refresh, self.part.timing.rfc.get(), now)
    }

    fn can_precharge(&self, bank: &BankState, now: u64) -> bool {
        passed(bank.activate, self.part.timing.ras.get(), now)
            && passed(bank.read, self.part.timing.rtp.get(), now)
            && passed(bank.write_data_end, self.part.timing.wr.get(), now)
    }

    /// Whether an event is long enough ago in all groups: `waits.1` in the group of bank `bank`, `waits.0` in the
    /// others.
    fn groups_allow(&self, bank: usize, event: fn(&GroupState) -> Option<u64>, waits: (u64, u64), now: u64) -> bool {
        let (short, long) = waits;
        let own = self.part.group(bank);
        let wait = |group| if group == own { long } else { short };
        self.groups.iter().enumerate().all(|(group, state)| passed(event(state), wait(group), now))
    }

    fn can_access(&self, number: usize, write: bool, now: u64) -> bool {
        let timing = &self.part.timing;
        let latency = if write { timing.cwl } else { timing.cl };
        let turns = write && !self.bus_writes;
        let free = self.bus_free + if turns { timing.turn.get() } else { 0 };
        let columns = (timing.ccd_s.get(), timing.ccd_l.get());
        let writes = (timing.wtr_s.get(), timing.wtr_l.get());
        passed(self.banks[number].activate, timing.rcd.get(), now)
            && self.groups_allow(number, |group| group.column, columns, now)
            && (write || self.groups_allow(number, |group| group.write_data_end, writes, now))
            && free <= now + latency.get()
    }

    fn can_activate(&self, number: usize, now: u64) -> bool {
        let timing = &self.part.timing;
        let in_window = self.activates.iter().filter(|&&activate| activate + timing.faw.get() > now);
        in_window.count() < 4
            && self.bank_can_activate(&self.banks[number], now)
            && self.groups_allow(number, |group| group.activate, (timing.rrd_s.get(), timing.rrd_l.get()), now)
    }

    /// Gives the first legal command for the queued requests: column commands, then activates, then precharges.
    fn serve(&mut self, now: u64, cycle: u64, wires: &mut Wires) {
        let queue: Vec<DramRequest> = wires.to_channel[self.index].entries(cycle).map(|entry| *entry).collect();
        let bank = |entry: &DramRequest| &self.banks[entry.place.bank];
        let is_hit = |entry: &DramRequest| bank(entry).open == Some(entry.place.row);
        let column = queue.iter().position(|e| is_hit(e) && self.can_access(e.place.bank, e.request.write, now));
        if let Some(index) = column {
            return self.access(index, now, cycle, wires);
        }
        let closed = |entry: &DramRequest| bank(entry).open.is_none();
        let activate = queue.iter().position(|e| closed(e) && self.can_activate(e.place.bank, now));
        let wanted = |number: usize| queue.iter().any(|e| e.place.bank == number && is_hit(e));
        let other = |entry: &DramRequest| !closed(entry) && !is_hit(entry) && !wanted(entry.place.bank);
        let precharge = queue.iter().position(|e| other(e) && self.can_precharge(bank(e), now));
        if let Some(index) = activate {
            let (number, row) = (queue[index].place.bank, queue[index].place.row);
            self.banks[number].open = Some(row);
            self.banks[number].activate = Some(now);
            self.groups[self.part.group(number)].activate = Some(now);
            self.activates.retain(|&activate| activate + self.part.timing.faw.get() > now);
            self.activates.push(now);
            self.log.give(now, Command::Activate { bank: number, row });
            self.counts.activates += 1;
            wires.to_channel[self.index].entries(cycle).skip(index).take(1).for_each(|entry| entry.activated = true);
        } else if let Some(index) = precharge {
            let number = queue[index].place.bank;
            self.banks[number].open = None;
            self.banks[number].precharge = Some(now);
            self.log.give(now, Command::Precharge { bank: number });
            wires.to_channel[self.index].entries(cycle).skip(index).take(1).for_each(|entry| entry.precharged = true);
        }
    }

    fn access(&mut self, index: usize, now: u64, cycle: u64, wires: &mut Wires) {
        let queue = &mut wires.to_channel[self.index];
        let entry = queue.entries(cycle).nth(index).expect("the index is of the queue");
        let DramRequest { request, place, activated, precharged, bursts_done } = *entry;
        entry.bursts_done += 1;
        let last = bursts_done + 1 == self.bursts;
        let auto_precharge = last && self.page == Page::Closed;
        let (bank, group) = (&mut self.banks[place.bank], &mut self.groups[self.part.group(place.bank)]);
        let column = place.column * self.bursts + bursts_done;
        let named = Column { bank: place.bank, row: place.row, column, auto_precharge };
        group.column = Some(now);
        self.bus_writes = request.write;
        if request.write {
            self.bus_free = now + self.part.timing.cwl.get() + self.part.burst_clocks.get();
            bank.write_data_end = Some(self.bus_free);
            group.write_data_end = Some(self.bus_free);
            self.log.give(now, Command::Write(named));
        } else {
            self.bus_free = now + self.part.timing.cl.get() + self.part.burst_clocks.get();
            bank.read = Some(now);
            self.log.give(now, Command::Read(named));
        }
        if auto_precharge {
            (bank.open, bank.closes_itself) = (None, true);
        }
        if bursts_done == 0 {
            if precharged {
                self.counts.row_conflicts += 1;
            } else if activated {
                self.counts.row_misses += 1;
            } else {
                self.counts.row_hits += 1;
            }
        }
        if last {
            queue.remove(index);
            self.count(&request);
            self.transfers.push_back((self.bus_free, request));
        }
    }

    fn count(&mut self, request: &Request) {
        if request.write {
            self.counts.writes += 1;
        } else {
            self.counts.reads += 1;
        }
        self.moved[request.class as usize] += request.bytes;
    }

    /// The log of requests and commands; `None` for a flat channel.
    pub(super) fn log(&mut self) -> Option<&mut ChannelLog> {
        self.flat.is_none().then_some(&mut self.log)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.transfers.is_empty() && self.flat.as_ref().is_none_or(Bus::is_empty)
    }

    pub(super) fn queues(&self, wires: &Wires) -> String {
        format!("queue {}, transfers {}", wires.to_channel[self.index].len(), self.transfers.len())
    }
}
