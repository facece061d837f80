//! DRAM channels with banks, open rows and refresh, scheduled first-ready, first-come-first-served (Rixner et al. 2000).

use std::collections::VecDeque;

use super::command::{Command, CommandLog};
use super::dram_timing::{DramSpec, Place, Timing};
use super::queue::Queue;
use super::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::{DramCounts, TrafficClass};

/// What was done for a request before its column command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Prepared {
    Nothing,
    Activated,
    Precharged,
}

#[derive(Clone, Copy, Debug)]
struct Pending {
    request: Request,
    bank: usize,
    row: u64,
    prepared: Prepared,
}

#[derive(Clone, Copy, Debug, Default)]
struct BankState {
    open: Option<u64>,
    activate_at: u64,
    column_at: u64,
    precharge_at: u64,
}

/// A column command's line whose data is on the bus.
#[derive(Clone, Copy, Debug)]
struct Transfer {
    ends: u64,
    request: Request,
}

/// One channel.
#[derive(Clone, Debug)]
struct Channel {
    part: PartId,
    queue: Queue<Pending>,
    banks: Vec<BankState>,
    transfers: VecDeque<Transfer>,
    /// When the data bus is free, in parts of a cycle.
    bus_free: u64,
    last_activate: Option<u64>,
    read_at: u64,
    refresh_due: u64,
    /// No command can be given before this cycle.
    command_at: u64,
    counts: DramCounts,
    moved: [Bytes; TrafficClass::ALL.len()],
    log: CommandLog,
}

/// What a channel can do next.
enum Next {
    Column(usize),
    Activate(usize),
    Precharge(usize),
    /// Nothing before this cycle.
    Wait(Option<u64>),
}

impl Channel {
    /// The first cycle in which a column command's data would find the bus free early enough.
    fn bus_at(&self, timing: &Timing, write: bool) -> u64 {
        (self.bus_free / timing.parts).saturating_sub(if write { timing.cwl } else { timing.cl })
    }

    fn next(&self, now: u64, timing: &Timing) -> Next {
        let mut wanted = 0u64;
        for (_, pending) in self.queue.visible(now) {
            if self.banks[pending.bank].open == Some(pending.row) {
                wanted |= 1 << pending.bank;
            }
        }
        let (read_bus, write_bus) = (self.bus_at(timing, false), self.bus_at(timing, true));
        let activate_after = self.last_activate.map_or(0, |last| last + timing.rrd);
        let (mut activate, mut precharge, mut earliest) = (None, None, None::<u64>);
        let mut later = |at: u64| earliest = Some(earliest.map_or(at, |other| other.min(at)));
        for (index, pending) in self.queue.visible(now) {
            let bank = &self.banks[pending.bank];
            let write = pending.request.write;
            match bank.open {
                Some(row) if row == pending.row => {
                    let at = bank.column_at.max(if write { write_bus } else { read_bus.max(self.read_at) });
                    if at <= now {
                        return Next::Column(index);
                    }
                    later(at);
                }
                None => {
                    let at = bank.activate_at.max(activate_after);
                    if at > now {
                        later(at);
                    } else if activate.is_none() {
                        activate = Some(index);
                    }
                }
                Some(_) if wanted >> pending.bank & 1 == 0 => {
                    if bank.precharge_at > now {
                        later(bank.precharge_at);
                    } else if precharge.is_none() {
                        precharge = Some(index);
                    }
                }
                Some(_) => {}
            }
        }
        match (activate, precharge) {
            (Some(index), _) => Next::Activate(index),
            (None, Some(index)) => Next::Precharge(index),
            (None, None) => Next::Wait(earliest),
        }
    }

    fn prepare(&mut self, index: usize, what: Prepared) -> &Pending {
        let Some(pending) = self.queue.get_mut(index) else { unreachable!("`next` names a request of the queue") };
        if pending.prepared != Prepared::Precharged {
            pending.prepared = what;
        }
        pending
    }

    fn column(&mut self, index: usize, now: u64, timing: &Timing, wake: &mut impl Wake) {
        let Some(Pending { request, bank, row, prepared }) = self.queue.take_at(index, now, wake) else {
            unreachable!("`next` names a request of the queue")
        };
        self.log.give(now, if request.write { Command::Write { bank, row } } else { Command::Read { bank, row } });
        let latency = if request.write { timing.cwl } else { timing.cl };
        self.bus_free = self.bus_free.max((now + latency) * timing.parts) + timing.line_parts;
        let ends = self.bus_free.div_ceil(timing.parts);
        let bank = &mut self.banks[bank];
        if request.write {
            bank.precharge_at = bank.precharge_at.max(ends + timing.wr);
            self.read_at = ends + timing.wtr;
            self.counts.writes += 1;
        } else {
            bank.precharge_at = bank.precharge_at.max(now + timing.rtp);
            self.counts.reads += 1;
        }
        match prepared {
            Prepared::Nothing => self.counts.row_hits += 1,
            Prepared::Activated => self.counts.row_misses += 1,
            Prepared::Precharged => self.counts.row_conflicts += 1,
        }
        self.moved[request.class as usize] += request.bytes;
        self.transfers.push_back(Transfer { ends, request });
    }

    /// Gives at most one command; returns before which cycle none can follow, if no request comes.
    fn command(&mut self, now: u64, timing: &Timing, wake: &mut impl Wake) -> u64 {
        if self.refresh_due <= now {
            return self.refresh(now, timing);
        }
        match self.next(now, timing) {
            Next::Column(index) => self.column(index, now, timing, wake),
            Next::Activate(index) => {
                let Pending { bank, row, .. } = *self.prepare(index, Prepared::Activated);
                self.log.give(now, Command::Activate { bank, row });
                self.banks[bank] = BankState {
                    open: Some(row),
                    activate_at: now + timing.rc,
                    column_at: now + timing.rcd,
                    precharge_at: now + timing.ras,
                };
                self.last_activate = Some(now);
            }
            Next::Precharge(index) => {
                let bank = self.prepare(index, Prepared::Precharged).bank;
                self.log.give(now, Command::Precharge { bank });
                self.banks[bank].close(now, timing);
            }
            Next::Wait(at) => return at.unwrap_or(u64::MAX).min(self.refresh_due),
        }
        now + 1
    }

    fn refresh(&mut self, now: u64, timing: &Timing) -> u64 {
        let ready = |at: fn(&BankState) -> u64, banks: &[BankState], open: bool| {
            banks.iter().filter(|bank| bank.open.is_some() == open).map(at).max()
        };
        if let Some(at) = ready(|bank| bank.precharge_at, &self.banks, true) {
            if at > now {
                return at;
            }
            self.banks.iter_mut().filter(|bank| bank.open.is_some()).for_each(|bank| bank.close(now, timing));
            self.log.give(now, Command::PrechargeAll);
            return now + 1;
        }
        if let Some(at) = ready(|bank| bank.activate_at, &self.banks, false).filter(|&at| at > now) {
            return at;
        }
        self.banks.iter_mut().for_each(|bank| bank.activate_at = now + timing.rfc);
        self.refresh_due += timing.refi;
        self.log.give(now, Command::Refresh);
        self.counts.refreshes += 1;
        now + 1
    }
}

impl BankState {
    fn close(&mut self, now: u64, timing: &Timing) {
        self.open = None;
        self.activate_at = self.activate_at.max(now + timing.rp);
    }
}

/// All channels of a DRAM.
#[derive(Clone, Debug)]
pub struct Dram {
    spec: DramSpec,
    timing: Timing,
    channels: Vec<Channel>,
}

impl Dram {
    /// An idle DRAM; its channels' numbers in the machine begin with `first`.
    pub fn new(spec: &DramSpec, machine_mhz: u64, line: u64, first: PartId) -> Self {
        let timing = spec.timing(machine_mhz, line);
        let channel = |index: u64| Channel {
            part: PartId(first.0 + index as u32),
            queue: Queue::new(spec.queue.size()),
            banks: vec![BankState::default(); spec.banks.size()],
            transfers: VecDeque::new(),
            bus_free: 0,
            last_activate: None,
            read_at: 0,
            refresh_due: timing.refi,
            command_at: 0,
            counts: DramCounts::default(),
            moved: [Bytes(0); TrafficClass::ALL.len()],
            log: CommandLog::default(),
        };
        Self { spec: spec.clone(), timing, channels: (0..spec.channels.get()).map(channel).collect() }
    }

    /// Puts a request into its channel's queue in cycle `now`; without a place, the asker is woken when there is one.
    pub fn put(&mut self, request: Request, now: u64, wake: &mut impl Wake) -> bool {
        let Place { channel, bank, row } = self.spec.place(request.line);
        let channel = &mut self.channels[channel];
        if !channel.queue.has_room(now) {
            channel.queue.wait_for_room(request.from, now, wake);
            return false;
        }
        channel.queue.put(Pending { request, bank, row, prepared: Prepared::Nothing }, now + 1);
        channel.command_at = channel.command_at.min(now + 1);
        wake.wake(channel.part, now + 1);
        true
    }

    /// Cycle `now` of channel `index`. `answer` hands a line to the bank of the L2 that asked for it.
    pub fn tick(&mut self, index: usize, now: u64, wake: &mut impl Wake, mut answer: impl FnMut(PartId, LineAddr)) {
        let channel = &mut self.channels[index];
        while let Some(&Transfer { request, .. }) = channel.transfers.front().filter(|transfer| transfer.ends <= now) {
            channel.transfers.pop_front();
            if !request.write {
                answer(request.from, request.line);
                wake.wake(request.from, now + 1);
            }
        }
        if channel.command_at <= now {
            // A request that was put in this cycle, before the channel acted, cannot be seen yet.
            let unseen = channel.queue.last_at().filter(|&at| at > now).unwrap_or(u64::MAX);
            channel.command_at = channel.command(now, &self.timing, wake).min(unseen);
        }
        wake.wake(channel.part, channel.command_at);
        if let Some(transfer) = channel.transfers.front() {
            wake.wake(channel.part, transfer.ends);
        }
    }

    /// The number of channels.
    pub fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Whether nothing is under way.
    pub fn is_idle(&self) -> bool {
        self.channels.iter().all(|channel| channel.queue.is_empty() && channel.transfers.is_empty())
    }

    /// Whether a refresh of channel `index` is due in cycle `now` and was not given yet.
    pub fn refresh_is_due(&self, index: usize, now: u64) -> bool {
        self.channels[index].refresh_due <= now
    }

    /// The commands of channel `index`.
    pub fn counts(&self, index: usize) -> &DramCounts {
        &self.channels[index].counts
    }

    /// Bytes that channel `index` moved, by class.
    pub fn moved(&self, index: usize) -> &[Bytes; TrafficClass::ALL.len()] {
        &self.channels[index].moved
    }

    /// From now on all commands are kept.
    pub fn keep_commands(&mut self) {
        self.channels.iter_mut().for_each(|channel| channel.log.keep());
    }

    /// The commands of channel `index`, as far as they were kept.
    pub fn log(&self, index: usize) -> &CommandLog {
        &self.channels[index].log
    }

    /// Timing in machine cycles.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// The state of the queue of channel `index`, for the report of a deadlock.
    pub fn queues(&self, index: usize) -> String {
        let Channel { queue, transfers, .. } = &self.channels[index];
        format!("queue {}/{}, transfers {}", queue.len(), queue.capacity(), transfers.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranged::{PowerOfTwo, Within};

    /// Nobody sleeps here: every cycle is acted in.
    struct Awake;

    impl Wake for Awake {
        fn wake(&mut self, _: PartId, _: u64) {}
    }

    /// A DRAM whose clock is the machine's, so that its parameters are cycles; lines of 64 B, two a burst pair.
    fn dram() -> Dram {
        Dram::new(&DramSpec::default(), 1600, 64, PartId(0))
    }

    fn request(line: u64, write: bool) -> Request {
        Request { line: LineAddr(line), class: TrafficClass::Node, write, bytes: Bytes(64), from: PartId(9) }
    }

    /// Puts the requests, each in its cycle or as soon as there is a place; the cycle of each answer.
    fn answers(dram: &mut Dram, requests: &[(u64, Request)], cycles: u64) -> Vec<u64> {
        let mut left = requests.iter().copied().peekable();
        let mut answers = Vec::new();
        for now in 0..cycles {
            while let Some((_, request)) = left.next_if(|&(at, _)| at <= now) {
                assert!(dram.put(request, now, &mut Awake));
            }
            dram.tick(0, now, &mut Awake, |_, _| answers.push(now));
        }
        answers
    }

    /// Clocks that a line is on the bus: two bursts of 8.
    const LINE: u64 = 16;
    /// Lines to the next row of the same bank: 2 columns, 8 banks, 16 columns.
    const ROW: u64 = 256;

    #[test]
    fn latencies_are_closed_forms() {
        let timing = *dram().timing();
        // The first command is given in the cycle after the request was put.
        let miss = 1 + timing.rcd + timing.cl + LINE;
        let hit = 1 + timing.cl + LINE;
        // The precharge waits for tRAS after the activate, which was given in cycle 1.
        let late = 1000;
        let conflict = 1 + timing.rp + timing.rcd + timing.cl + LINE;
        for (second, at, expected) in [(1, late, late + hit), (ROW, late, late + conflict), (2, late, late + miss)] {
            let mut dram = dram();
            let got = answers(&mut dram, &[(0, request(0, false)), (at, request(second, false))], 3000);
            assert_eq!(got, [miss, expected], "line {second}");
            let counts = *dram.counts(0);
            let met = (counts.row_hits, counts.row_misses, counts.row_conflicts);
            assert_eq!(met, [(1, 1, 0), (0, 1, 1), (0, 2, 0)][[1, ROW, 2].iter().position(|&l| l == second).unwrap()]);
        }
    }

    #[test]
    fn an_early_conflict_waits_for_the_row_to_be_restored() {
        let mut dram = dram();
        let timing = *dram.timing();
        let got = answers(&mut dram, &[(0, request(0, false)), (0, request(ROW, false))], 3000);
        let precharge = 1 + timing.ras;
        assert_eq!(got[1], precharge + timing.rp + timing.rcd + timing.cl + LINE);
    }

    #[test]
    fn a_read_after_a_write_waits_for_the_turn() {
        let mut dram = dram();
        let timing = *dram.timing();
        let got = answers(&mut dram, &[(0, request(0, true)), (0, request(1, false))], 3000);
        let write_ends = 1 + timing.rcd + timing.cwl + LINE;
        assert_eq!(got, [write_ends + timing.wtr + timing.cl + LINE]);
    }

    #[test]
    fn row_hits_go_first() {
        let mut dram = dram();
        let requests = [(0, request(0, false)), (0, request(ROW, false)), (0, request(1, false))];
        answers(&mut dram, &requests, 3000);
        let counts = dram.counts(0);
        assert_eq!((counts.row_hits, counts.row_misses, counts.row_conflicts), (1, 1, 1));
    }

    #[test]
    fn a_chain_of_row_hits_fills_the_bus() {
        let mut dram = dram();
        let first = 1 + dram.timing().rcd + dram.timing().cl;
        // The lines of one row: columns 0 and 1, then those above the bank bits.
        let row: Vec<_> = (0..32).map(|line| (0, request(line / 2 * 16 + line % 2, false))).collect();
        let got = answers(&mut dram, &row, 3000);
        assert_eq!(got, (1..=32).map(|line| first + line * LINE).collect::<Vec<_>>());
    }

    /// The bus moves a line in 16 / 1600 MHz = 10 ns, 1.4 cycles of 140 MHz: 5 lines take 7 cycles, not 10.
    #[test]
    fn a_fraction_of_a_cycle_is_not_lost() {
        let mut dram = Dram::new(&DramSpec::default(), 140, 64, PartId(0));
        assert_eq!((dram.timing().line_parts, dram.timing().parts), (2240, 1600));
        let row: Vec<_> = (0..30).map(|line| (0, request(line / 2 * 16 + line % 2, false))).collect();
        let got = answers(&mut dram, &row, 500);
        assert_eq!(got[29] - got[4], 25 * 7 / 5);
    }

    #[test]
    fn refreshes_come_every_refi_and_stop_the_channel() {
        let mut dram = dram();
        let timing = *dram.timing();
        let got = answers(&mut dram, &[(timing.refi, request(0, false))], 10 * timing.refi + 1);
        // All banks are closed: the refresh is given when it is due, the activate tRFC later.
        assert_eq!(got, [timing.refi + timing.rfc + timing.rcd + timing.cl + LINE]);
        assert_eq!(dram.counts(0).refreshes, 10);
    }

    /// A channel that never waits for requests: between refreshes a line follows the other.
    #[test]
    fn bandwidth_is_limited_by_refreshes_alone() {
        let mut dram = dram();
        let timing = *dram.timing();
        let intervals = 20;
        // Before the first refresh: the activate in cycle 1.
        let (mut first, mut expected) = (1 + timing.rcd, 0);
        for due in (1..=intervals).map(|interval| interval * timing.refi) {
            let lines = (due - first).div_ceil(LINE);
            let last = first + (lines - 1) * LINE;
            expected += lines;
            first = due.max(last + timing.rtp) + timing.rp + timing.rfc + timing.rcd;
        }
        let (mut column, cycles) = (0, intervals * timing.refi);
        for now in 0..cycles {
            // The 32 lines of one row, over and over.
            while dram.put(request(column / 2 * 16 + column % 2, false), now, &mut Awake) {
                column = (column + 1) % 32;
            }
            dram.tick(0, now, &mut Awake, |_, _| {});
        }
        let counts = dram.counts(0);
        assert_eq!((counts.reads, counts.row_conflicts), (expected, 0));
        // LPDDR4 of one channel keeps 94 % of its peak.
        let (busy, share) = (expected * LINE, 1.0 - (timing.rp + timing.rfc + timing.rcd) as f64 / timing.refi as f64);
        assert!((busy as f64 / cycles as f64 - share).abs() < 0.005, "{busy} of {cycles}, {share}");
    }

    #[test]
    fn a_refresh_closes_the_rows() {
        let mut dram = dram();
        let timing = *dram.timing();
        let before = timing.refi - timing.rcd - timing.cl - LINE - 2;
        answers(&mut dram, &[(before, request(0, false)), (2 * before, request(1, false))], 2 * timing.refi);
        assert_eq!(dram.counts(0).row_misses, 2);
    }

    #[test]
    fn a_full_queue_refuses() {
        let spec = DramSpec { queue: Within::new(1).unwrap(), ..DramSpec::default() };
        let mut dram = Dram::new(&spec, 1600, 64, PartId(0));
        assert!(dram.put(request(0, false), 0, &mut Awake));
        assert!(!dram.put(request(1, false), 0, &mut Awake));
    }

    #[test]
    fn every_line_has_its_own_place() {
        use crate::memory::dram_timing::Field;
        let spec = DramSpec {
            channels: PowerOfTwo::new(4).unwrap(),
            mapping: vec![
                Field::Column(2),
                Field::Channel(1),
                Field::Bank(3),
                Field::Channel(1),
                Field::Column(3),
                Field::Row,
            ],
            ..DramSpec::default()
        };
        spec.check(64, 1600).unwrap();
        let mut seen = std::collections::BTreeMap::new();
        for line in 0..4096 {
            let Place { channel, bank, row } = spec.place(LineAddr(line));
            *seen.entry((channel, bank, row)).or_insert(0) += 1;
        }
        assert_eq!(seen.len(), 4096 / 32);
        assert!(seen.values().all(|&columns| columns == 32));
        assert!(seen.keys().all(|&(channel, bank, row)| channel < 4 && bank < 8 && row < 4));
    }
}
