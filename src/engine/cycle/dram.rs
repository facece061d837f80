//! A channel of the DRAM: remembers when each command was last given, and asks of every command whether it is legal now.

use std::collections::VecDeque;

use super::wires::{DramRequest, Request, Wires};
use crate::memory::command::{Command, CommandLog};
use crate::memory::dram_timing::{DramSpec, Timing};
use crate::quantity::Bytes;
use crate::stats::{DramCounts, TrafficClass};

/// When something last happened in a bank.
#[derive(Clone, Debug, Default)]
struct BankState {
    open: Option<u64>,
    activate: Option<u64>,
    precharge: Option<u64>,
    read: Option<u64>,
    write_data_end: Option<u64>,
}

pub struct Channel {
    index: usize,
    timing: Timing,
    banks: Vec<BankState>,
    activate: Option<u64>,
    write_data_end: Option<u64>,
    refresh: Option<u64>,
    /// When the data bus is free, in parts of a cycle.
    bus_free: u64,
    transfers: VecDeque<(u64, Request)>,
    pub counts: DramCounts,
    pub moved: [Bytes; TrafficClass::ALL.len()],
    pub log: CommandLog,
}

/// Whether in cycle `now` at least `wait` cycles have passed since an event, if there was one.
fn passed(event: Option<u64>, wait: u64, now: u64) -> bool {
    event.is_none_or(|event| now >= event + wait)
}

impl Channel {
    pub fn new(spec: &DramSpec, index: usize, machine_mhz: u64, line: u64) -> Self {
        Self {
            index,
            timing: spec.timing(machine_mhz, line),
            banks: vec![BankState::default(); spec.banks.size()],
            activate: None,
            write_data_end: None,
            refresh: None,
            bus_free: 0,
            transfers: VecDeque::new(),
            counts: DramCounts::default(),
            moved: Default::default(),
            log: CommandLog::default(),
        }
    }

    pub fn tick(&mut self, now: u64, wires: &mut Wires) {
        while let Some(&(end, request)) = self.transfers.front()
            && end <= now
        {
            self.transfers.pop_front();
            if !request.write {
                wires.from_dram[request.from].put(now, request.line);
            }
        }
        if self.refresh_is_due(now) {
            self.toward_refresh(now);
        } else {
            self.serve(now, wires);
        }
    }

    pub fn refresh_is_due(&self, now: u64) -> bool {
        now >= (self.counts.refreshes + 1) * self.timing.refi
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
        passed(bank.activate, self.timing.rc, now)
            && passed(bank.precharge, self.timing.rp, now)
            && passed(self.refresh, self.timing.rfc, now)
    }

    fn can_precharge(&self, bank: &BankState, now: u64) -> bool {
        passed(bank.activate, self.timing.ras, now)
            && passed(bank.read, self.timing.rtp, now)
            && passed(bank.write_data_end, self.timing.wr, now)
    }

    fn can_access(&self, bank: &BankState, write: bool, now: u64) -> bool {
        let data = now + if write { self.timing.cwl } else { self.timing.cl };
        passed(bank.activate, self.timing.rcd, now)
            && (write || passed(self.write_data_end, self.timing.wtr, now))
            && self.bus_free < (data + 1) * self.timing.parts
    }

    /// Gives the command that the requests in the queue ask for, if one is legal.
    fn serve(&mut self, now: u64, wires: &mut Wires) {
        let queue: Vec<DramRequest> = wires.to_channel[self.index].entries(now).map(|entry| *entry).collect();
        let bank = |entry: &DramRequest| &self.banks[entry.place.bank];
        let is_hit = |entry: &DramRequest| bank(entry).open == Some(entry.place.row);
        let column = queue.iter().position(|e| is_hit(e) && self.can_access(bank(e), e.request.write, now));
        if let Some(index) = column {
            return self.access(index, now, wires);
        }
        let closed = |entry: &DramRequest| bank(entry).open.is_none();
        let spaced = passed(self.activate, self.timing.rrd, now);
        let activate = queue.iter().position(|e| closed(e) && spaced && self.bank_can_activate(bank(e), now));
        let wanted = |number: usize| queue.iter().any(|e| e.place.bank == number && is_hit(e));
        let other = |entry: &DramRequest| !closed(entry) && !is_hit(entry) && !wanted(entry.place.bank);
        let precharge = queue.iter().position(|e| other(e) && self.can_precharge(bank(e), now));
        if let Some(index) = activate {
            let (number, row) = (queue[index].place.bank, queue[index].place.row);
            self.banks[number].open = Some(row);
            self.banks[number].activate = Some(now);
            self.activate = Some(now);
            self.log.give(now, Command::Activate { bank: number, row });
            wires.to_channel[self.index].entries(now).skip(index).take(1).for_each(|entry| entry.activated = true);
        } else if let Some(index) = precharge {
            let number = queue[index].place.bank;
            self.banks[number].open = None;
            self.banks[number].precharge = Some(now);
            self.log.give(now, Command::Precharge { bank: number });
            wires.to_channel[self.index].entries(now).skip(index).take(1).for_each(|entry| entry.precharged = true);
        }
    }

    fn access(&mut self, index: usize, now: u64, wires: &mut Wires) {
        let entry = wires.to_channel[self.index].remove(index);
        let DramRequest { request, place, activated, precharged } = entry.expect("the index is of the queue");
        let (bank, row) = (place.bank, place.row);
        let wait = if request.write { self.timing.cwl } else { self.timing.cl };
        let begin = self.bus_free.max((now + wait) * self.timing.parts);
        self.bus_free = begin + self.timing.line_parts;
        let end = self.bus_free.div_ceil(self.timing.parts);
        if request.write {
            self.write_data_end = Some(end);
            self.banks[bank].write_data_end = Some(end);
            self.counts.writes += 1;
            self.log.give(now, Command::Write { bank, row });
        } else {
            self.banks[bank].read = Some(now);
            self.counts.reads += 1;
            self.log.give(now, Command::Read { bank, row });
        }
        if precharged {
            self.counts.row_conflicts += 1;
        } else if activated {
            self.counts.row_misses += 1;
        } else {
            self.counts.row_hits += 1;
        }
        self.moved[request.class as usize] += request.bytes;
        self.transfers.push_back((end, request));
    }

    pub fn is_empty(&self) -> bool {
        self.transfers.is_empty()
    }

    pub fn queues(&self, wires: &Wires) -> String {
        format!("queue {}, transfers {}", wires.to_channel[self.index].len(), self.transfers.len())
    }
}
