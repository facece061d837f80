//! A DRAM channel with first-ready, first-come-first-served scheduling (FR-FCFS; Rixner et al. 2000).

use super::command::{ChannelLog, Column, Command};
use super::mapping::Place;
use super::part::{DramPart, Timing};
use super::spec::{Clocks, DramSpec, Page};
use crate::memory::queue::{Load, Queue};
use crate::memory::ring::Ring;
use crate::memory::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{DramCounts, TrafficClass};

/// Row commands given for a request before its first column command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Prepared {
    Nothing,
    Activated,
    Precharged,
}

#[derive(Clone, Copy, Debug)]
struct Pending {
    request: Request,
    place: Place,
    prepared: Prepared,
    /// Column commands given so far.
    done: u64,
}

/// The earliest clock in which a bank allows each command, by the bank's own constraints alone.
#[derive(Clone, Copy, Debug, Default)]
struct BankState {
    /// The bank group.
    group: usize,
    open: Option<u64>,
    activate_at: u64,
    column_at: u64,
    precharge_at: u64,
}

/// The earliest clock in which a bank group, or the whole channel, allows each command.
#[derive(Clone, Copy, Debug, Default)]
struct Earliest {
    activate: u64,
    column: u64,
    read: u64,
}

/// A line whose last column command has been given.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    /// The first cycle that begins after all data of the line has passed.
    at: u64,
    request: Request,
}

/// One channel. Times are clocks of the DRAM unless stated otherwise.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    part: PartId,
    dram: DramPart,
    page: Page,
    clocks: Clocks,
    bursts: u64,
    queue: Queue<Pending>,
    banks: Vec<BankState>,
    groups: Vec<Earliest>,
    any: Earliest,
    transfers: Ring<Transfer>,
    /// The first clock in which the data bus is free.
    bus_free: u64,
    /// Whether the last burst on the bus was read.
    bus_reads: bool,
    /// The clocks of the last four activates, newest first.
    activates: [Option<u64>; 4],
    refresh_due: u64,
    /// No command can be given before this clock.
    command_at: u64,
    /// The next planned command; `None` if it must be planned again.
    plan: Option<Planned>,
    counts: DramCounts,
    moved: [Bytes; TrafficClass::ALL.len()],
    log: ChannelLog,
}

/// Kinds of commands for a request, highest priority first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Column,
    Activate,
    Precharge,
}

impl What {
    const ALL: [Self; 3] = [Self::Column, Self::Activate, Self::Precharge];
}

/// The next command, unless a refresh is due earlier.
#[derive(Clone, Copy, Debug)]
struct Planned {
    clock: u64,
    what: What,
    /// The index of its request in the queue.
    index: usize,
    /// Number of requests examined, from the front of the queue.
    looked_at: usize,
    /// Banks whose open row one of the examined requests needs; one bit per bank.
    wanted: u64,
}

/// Channel-wide constraints on the commands of all requests, from a clock on.
#[derive(Clone, Copy, Debug)]
struct Ahead {
    clock: u64,
    /// The earliest clock for a read, and for a write, by the constraints of the bus.
    bus: [u64; 2],
    /// The earliest clock for an activate.
    activate: u64,
}

impl Channel {
    /// An idle channel with the number `part` in the machine.
    pub(super) fn new(spec: &DramSpec, clocks: Clocks, line: u64, part: PartId) -> Self {
        let dram = spec.part.clone();
        Self {
            part,
            page: spec.page,
            clocks,
            bursts: dram.bursts(line),
            queue: Queue::new(spec.queue.size()),
            banks: (0..dram.banks.size())
                .map(|bank| BankState { group: dram.group(bank), ..BankState::default() })
                .collect(),
            groups: vec![Earliest::default(); dram.bank_groups.size()],
            any: Earliest::default(),
            transfers: Ring::new(),
            bus_free: 0,
            bus_reads: false,
            activates: [None; 4],
            refresh_due: dram.timing.refi.get(),
            command_at: 0,
            plan: None,
            counts: DramCounts::default(),
            moved: [Bytes(0); TrafficClass::ALL.len()],
            log: ChannelLog::default(),
            dram,
        }
    }

    /// Puts a request into the queue in cycle `now`. Without a place, it returns false and wakes the requester later.
    pub(super) fn put(&mut self, request: Request, place: Place, now: u64, wake: &mut impl Wake) -> bool {
        if !self.queue.has_room(now) {
            self.queue.wait_for_room(request.from, now, wake);
            return false;
        }
        self.queue.put(Pending { request, place, prepared: Prepared::Nothing, done: 0 }, now + 1);
        let seen = self.clocks.first(now + 1);
        self.log.put(seen - 1, request.line, request.write);
        self.command_at = self.command_at.min(seen);
        wake.wake(self.part, self.clocks.cycle(seen));
        true
    }

    /// Simulates cycle `now`. `answer` sends a line to the L2 bank that requested it.
    pub(super) fn tick(&mut self, now: u64, wake: &mut impl Wake, mut answer: impl FnMut(PartId, LineAddr)) {
        while let Some(&Transfer { request, .. }) = self.transfers.front().filter(|transfer| transfer.at <= now) {
            self.transfers.pop_front();
            if !request.write {
                answer(request.from, request.line);
                wake.wake(request.from, now + 1);
            }
        }
        let end = self.clocks.first(now + 1);
        while self.command_at < end {
            self.command_at = self.command(self.command_at, now, wake);
        }
        // A request put in this cycle, before the channel acted, is not visible yet.
        if self.queue.last_at().is_some_and(|at| at > now) {
            self.command_at = end;
        }
        wake.wake(self.part, self.clocks.cycle(self.command_at));
        if let Some(transfer) = self.transfers.front() {
            wake.wake(self.part, transfer.at);
        }
    }

    /// Gives at most one command in clock `clock` of cycle `now`. Returns the earliest clock of a further command if no
    /// request comes.
    fn command(&mut self, clock: u64, now: u64, wake: &mut impl Wake) -> u64 {
        if self.refresh_due <= clock {
            self.plan = None;
            return self.refresh(clock);
        }
        let known = self.plan.take().and_then(|plan| self.plan_on(plan, clock, now));
        let Some(plan) = known.or_else(|| self.plan(clock, now)) else { return self.refresh_due };
        if plan.clock > clock {
            self.plan = Some(plan);
            return plan.clock.min(self.refresh_due);
        }
        match plan.what {
            What::Column => self.column(plan.index, clock, now, wake),
            What::Activate => self.activate(plan.index, clock),
            What::Precharge => {
                let bank = self.prepare(plan.index, Prepared::Precharged).bank;
                self.log.give(clock, Command::Precharge { bank });
                self.banks[bank].close(clock, &self.dram.timing);
            }
        }
        clock + 1
    }

    /// Plans the first legal command from clock `clock` on, ignoring refreshes. Among commands that are legal at the
    /// same clock, a column command precedes an activate, an activate a precharge; then the oldest request wins.
    fn plan(&self, clock: u64, now: u64) -> Option<Planned> {
        let mut wanted = 0u64;
        for (_, Pending { place, .. }) in self.queue.visible(now) {
            wanted |= u64::from(self.banks[place.bank].open == Some(place.row)) << place.bank;
        }
        let ahead = self.ahead(clock);
        // Per kind: the first clock in which a command is legal, and its request.
        let mut first = [(u64::MAX, 0); 3];
        let mut looked_at = 0;
        for (index, pending) in self.queue.visible(now) {
            looked_at = index + 1;
            let Some((what, at)) = self.next_for(pending, wanted, &ahead) else { continue };
            let first = &mut first[what as usize];
            if at < first.0 {
                *first = (at, index);
            }
        }
        let (what, (clock, index)) = What::ALL.into_iter().zip(first).min_by_key(|&(_, (at, _))| at)?;
        (clock < u64::MAX).then_some(Planned { clock, what, index, looked_at, wanted })
    }

    /// Extends `plan` with the requests that have come since; `plan` has no command before clock `clock`. Returns
    /// `None` if the planned command would precharge a row that a new request needs.
    fn plan_on(&self, mut plan: Planned, clock: u64, now: u64) -> Option<Planned> {
        if self.queue.is_visible(plan.looked_at, now) {
            let ahead = self.ahead(clock);
            for (index, pending) in self.queue.visible_from(plan.looked_at, now) {
                let Place { bank, row, .. } = pending.place;
                plan.looked_at = index + 1;
                plan.wanted |= u64::from(self.banks[bank].open == Some(row)) << bank;
                let next = self.next_for(pending, plan.wanted, &ahead);
                if let Some((what, at)) = next.filter(|&(what, at)| (at, what) < (plan.clock, plan.what)) {
                    (plan.clock, plan.what, plan.index) = (at, what, index);
                }
            }
            if plan.what == What::Precharge {
                let bank = self.queue.get(plan.index)?.place.bank;
                return Some(plan).filter(|plan| plan.wanted >> bank & 1 == 0);
            }
        }
        Some(plan)
    }

    fn ahead(&self, clock: u64) -> Ahead {
        let bus = [self.bus_at(false), self.bus_at(true)].map(|at| at.max(self.any.column).max(clock));
        let window = self.activates[3].map_or(0, |fourth| fourth + self.dram.timing.faw.get());
        Ahead { clock, bus, activate: self.any.activate.max(window).max(clock) }
    }

    /// The next command for a request and its first legal clock; `None` if its bank has another open row that is
    /// `wanted`.
    #[inline]
    fn next_for(&self, pending: &Pending, wanted: u64, ahead: &Ahead) -> Option<(What, u64)> {
        let Place { bank: number, row, .. } = pending.place;
        let bank = &self.banks[number];
        let group = &self.groups[bank.group];
        match bank.open {
            Some(open) if open == row => {
                let write = pending.request.write;
                let column = bank.column_at.max(group.column).max(ahead.bus[usize::from(write)]);
                let at = if write { column } else { column.max(self.any.read).max(group.read) };
                Some((What::Column, at))
            }
            None => Some((What::Activate, bank.activate_at.max(ahead.activate).max(group.activate))),
            Some(_) if wanted >> number & 1 == 0 => Some((What::Precharge, bank.precharge_at.max(ahead.clock))),
            Some(_) => None,
        }
    }

    /// The first clock in which the bus is free for data of this direction.
    fn bus_free_for(&self, write: bool) -> u64 {
        self.bus_free + if write && self.bus_reads { self.dram.timing.turn.get() } else { 0 }
    }

    fn latency(&self, write: bool) -> u64 {
        if write { self.dram.timing.cwl.get() } else { self.dram.timing.cl.get() }
    }

    /// The first clock of a column command whose data finds the bus free.
    fn bus_at(&self, write: bool) -> u64 {
        self.bus_free_for(write).saturating_sub(self.latency(write))
    }

    fn prepare(&mut self, index: usize, what: Prepared) -> Place {
        let Some(pending) = self.queue.get_mut(index) else { unreachable!("`next` names a request of the queue") };
        if pending.prepared != Prepared::Precharged {
            pending.prepared = what;
        }
        pending.place
    }

    fn activate(&mut self, index: usize, clock: u64) {
        let Place { bank, row, .. } = self.prepare(index, Prepared::Activated);
        self.log.give(clock, Command::Activate { bank, row });
        self.counts.activates += 1;
        let timing = &self.dram.timing;
        self.any.activate = clock + timing.rrd_s.get();
        let state = &mut self.banks[bank];
        self.groups[state.group].activate = clock + timing.rrd_l.get();
        *state = BankState {
            group: state.group,
            open: Some(row),
            activate_at: clock + timing.rc.get(),
            column_at: clock + timing.rcd.get(),
            precharge_at: clock + timing.ras.get(),
        };
        self.activates.rotate_right(1);
        self.activates[0] = Some(clock);
    }

    fn column(&mut self, index: usize, clock: u64, now: u64, wake: &mut impl Wake) {
        let Some(pending) = self.queue.get_mut(index) else { unreachable!("`next` names a request of the queue") };
        pending.done += 1;
        let Pending { request, place: Place { bank, row, column, .. }, prepared, done } = *pending;
        let last = done == self.bursts;
        let auto_precharge = last && self.page == Page::Closed;
        let named = Column { bank, row, column: column * self.bursts + done - 1, auto_precharge };
        self.log.give(clock, if request.write { Command::Write(named) } else { Command::Read(named) });
        self.bus_free = clock + self.latency(request.write) + self.dram.burst_clocks.get();
        self.bus_reads = !request.write;
        let ends = self.bus_free;
        let timing = &self.dram.timing;
        let state = &mut self.banks[bank];
        let group = &mut self.groups[state.group];
        self.any.column = clock + timing.ccd_s.get();
        group.column = clock + timing.ccd_l.get();
        if request.write {
            state.precharge_at = state.precharge_at.max(ends + timing.wr.get());
            self.any.read = ends + timing.wtr_s.get();
            group.read = ends + timing.wtr_l.get();
        } else {
            state.precharge_at = state.precharge_at.max(clock + timing.rtp.get());
        }
        if auto_precharge {
            state.close(state.precharge_at, timing);
        }
        if done == 1 {
            match prepared {
                Prepared::Nothing => self.counts.row_hits += 1,
                Prepared::Activated => self.counts.row_misses += 1,
                Prepared::Precharged => self.counts.row_conflicts += 1,
            }
        }
        if last {
            self.queue.take_at(index, now, wake);
            *(if request.write { &mut self.counts.writes } else { &mut self.counts.reads }) += 1;
            self.moved[request.class as usize] += request.bytes;
            self.transfers.push_back(Transfer { at: self.clocks.cycle_after(ends), request });
        }
    }

    fn refresh(&mut self, clock: u64) -> u64 {
        let ready = |at: fn(&BankState) -> u64, banks: &[BankState], open: bool| {
            banks.iter().filter(|bank| bank.open.is_some() == open).map(at).max()
        };
        let timing = &self.dram.timing;
        if let Some(at) = ready(|bank| bank.precharge_at, &self.banks, true) {
            if at > clock {
                return at;
            }
            self.banks.iter_mut().filter(|bank| bank.open.is_some()).for_each(|bank| bank.close(clock, timing));
            self.log.give(clock, Command::PrechargeAll);
            return clock + 1;
        }
        if let Some(at) = ready(|bank| bank.activate_at, &self.banks, false).filter(|&at| at > clock) {
            return at;
        }
        self.banks.iter_mut().for_each(|bank| bank.activate_at = clock + timing.rfc.get());
        self.refresh_due += timing.refi.get();
        self.log.give(clock, Command::Refresh);
        self.counts.refreshes += 1;
        clock + 1
    }

    /// Whether no request or transfer is pending.
    pub(super) fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.transfers.is_empty()
    }

    /// The clock in which the next refresh is due.
    pub(super) fn refresh_due(&self) -> u64 {
        self.refresh_due
    }

    /// Counts of commands and requests.
    pub(super) fn counts(&self) -> &DramCounts {
        &self.counts
    }

    /// Bytes moved, by class.
    pub(super) fn moved(&self) -> &[Bytes; TrafficClass::ALL.len()] {
        &self.moved
    }

    /// The log of requests and commands, empty unless it is kept.
    pub(super) fn log(&mut self) -> &mut ChannelLog {
        &mut self.log
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
        let Self { queue, transfers, .. } = self;
        format!("queue {}/{}, transfers {}", queue.len(), queue.capacity(), transfers.len())
    }
}

impl BankState {
    /// Closes the row from clock `clock` on.
    fn close(&mut self, clock: u64, timing: &Timing) {
        self.open = None;
        self.activate_at = self.activate_at.max(clock + timing.rp.get());
    }
}
