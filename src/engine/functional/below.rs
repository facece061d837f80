//! What lies below the L1s: the L2's banks, each taking one access a cycle, in front of the machine's own model of the DRAM.

use std::collections::VecDeque;

use super::calendar::Calendar;
use crate::engine::tally::{BankTally, ChannelTally};
use crate::machine::MachineSpec;
use crate::memory::bank::{BankedSpec, Served};
use crate::memory::cache::{Access, Cache, Fill, Lookup};
use crate::memory::dram::Dram;
use crate::memory::l2::Home;
use crate::memory::tags::Victim;
use crate::memory::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;

/// A line that comes to an L1.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// The unit.
    pub unit: u32,
    /// The line.
    pub line: LineAddr,
}

/// The calendar as the DRAM's model sees it: parts are events.
struct Alarm<'a> {
    calendar: &'a mut Calendar,
    first: u32,
    /// When each part is due; an announcement that was overtaken by an earlier one is let pass.
    due: &'a mut [u64],
}

impl Wake for Alarm<'_> {
    fn wake(&mut self, part: PartId, at: u64) {
        let due = &mut self.due[part.0 as usize];
        if at < *due {
            *due = at;
            self.calendar.put(at, self.first + part.0);
        }
    }
}

#[derive(Clone, Debug)]
struct Bank {
    cache: Cache,
    latency: u64,
    /// The first cycle in which an access can be made.
    free_at: u64,
    /// Requests behind one that found no register or target.
    stalled: VecDeque<Request>,
    out: VecDeque<Request>,
    served: Served,
}

/// L2 and DRAM. Its parts are numbered: banks, then channels.
#[derive(Clone, Debug)]
pub struct Below {
    /// Banks of all cores, and how many a core has.
    banks: Vec<Bank>,
    of_core: usize,
    dram: Dram,
    homes: [Home; TrafficClass::ALL.len()],
    line: Bytes,
    /// The first event that is a part's.
    first: u32,
    due: Vec<u64>,
    /// Answers on their way, at the places of their events; then the free places.
    answers: Vec<Answer>,
    free_answers: Vec<u32>,
    waiting: Vec<u32>,
    came: Vec<(u32, LineAddr)>,
}

impl Below {
    /// The memory of `machine`, empty. Events from `first` on are its own.
    pub fn new(machine: &MachineSpec, first: u32) -> Self {
        let line = machine.line_bytes.get();
        let (cores, of_core) = (machine.cores.size(), machine.l2.banks() as usize);
        let banks = (cores * of_core) as u32;
        let bank = |spec: &BankedSpec| Bank {
            cache: spec.bank_cache(line),
            latency: spec.latency.get(),
            free_at: 0,
            stalled: VecDeque::new(),
            out: VecDeque::new(),
            served: Served::default(),
        };
        let l2 = machine.l2.caches();
        let dram = Dram::new(&machine.dram, machine.clock_mhz.get(), line, PartId(banks));
        Self {
            banks: (0..cores)
                .flat_map(|_| l2.iter().flat_map(|(_, spec)| (0..spec.banks.get()).map(|_| bank(spec))))
                .collect(),
            of_core,
            homes: machine.l2.homes(),
            due: vec![u64::MAX; banks as usize + dram.channels()],
            dram,
            line: Bytes(line),
            first,
            answers: Vec::new(),
            free_answers: Vec::new(),
            waiting: Vec::new(),
            came: Vec::new(),
        }
    }

    /// Wakes the channels for the first time.
    pub fn begin(&mut self, calendar: &mut Calendar) {
        let Self { due, first, banks, dram, .. } = self;
        let mut alarm = Alarm { calendar, first: *first, due };
        (0..dram.channels()).for_each(|channel| alarm.wake(PartId((banks.len() + channel) as u32), 0));
    }

    /// A unit's L1 sends `request` to its core's L2 in cycle `at`; `from` is the unit.
    pub fn request(&mut self, core: usize, request: Request, at: u64, calendar: &mut Calendar) {
        let index = core * self.of_core + self.homes[request.class as usize].bank(request.line);
        if self.banks[index].stalled.is_empty() {
            self.access(index, request, at + 1, calendar);
        } else {
            self.banks[index].stalled.push_back(request);
        }
    }

    fn access(&mut self, index: usize, request: Request, at: u64, calendar: &mut Calendar) {
        let bank = &mut self.banks[index];
        let at = at.max(bank.free_at);
        let Request { line, class, write, bytes, from, marked } = request;
        let (access, reader) = if write { (Access::Write, None) } else { (Access::Read, Some(from.0)) };
        let lookup = bank.cache.access(line, class, access, reader, true);
        match lookup {
            Lookup::Stalled => return bank.stalled.push_front(request),
            Lookup::Hit if !write => self.answer(index, from.0, line, at, calendar),
            Lookup::Hit | Lookup::Merged => {}
            Lookup::Miss | Lookup::Passed => {
                let (bytes, from) = (self.line, PartId(index as u32));
                let write = lookup == Lookup::Passed;
                bank.out.push_back(Request { line, class, write, bytes, from, marked: false });
                self.wake(index as u32, at, calendar);
            }
        }
        let bank = &mut self.banks[index];
        bank.free_at = at + 1;
        if write {
            bank.served.write(class, bytes);
        } else {
            bank.served.read(class, bytes, lookup == Lookup::Miss, marked);
        }
    }

    fn wake(&mut self, part: u32, at: u64, calendar: &mut Calendar) {
        Alarm { calendar, first: self.first, due: &mut self.due }.wake(PartId(part), at);
    }

    /// The line goes to the unit's L1; it was found, or came, in cycle `at`.
    fn answer(&mut self, bank: usize, unit: u32, line: LineAddr, at: u64, calendar: &mut Calendar) {
        let answer = Answer { unit, line };
        let place = match self.free_answers.pop() {
            Some(place) => {
                self.answers[place as usize] = answer;
                place
            }
            None => {
                self.answers.push(answer);
                self.answers.len() as u32 - 1
            }
        };
        calendar.put(at + self.banks[bank].latency + 1, self.first + self.due.len() as u32 + place);
    }

    /// An event of this memory in cycle `now`; a line that comes to an L1, if it is one.
    pub fn event(&mut self, event: u32, now: u64, calendar: &mut Calendar) -> Option<Answer> {
        let part = (event - self.first) as usize;
        match part.checked_sub(self.due.len()) {
            Some(place) => {
                self.free_answers.push(place as u32);
                return Some(self.answers[place]);
            }
            None if self.due[part] != now => return None,
            None => self.due[part] = u64::MAX,
        }
        match part.checked_sub(self.banks.len()) {
            None => self.send(part, now, calendar),
            Some(channel) => {
                let Self { due, first, dram, came, .. } = self;
                let mut alarm = Alarm { calendar, first: *first, due };
                dram.tick(channel, now, &mut alarm, |to, line| came.push((to.0, line)));
                for index in 0..self.came.len() {
                    let (bank, line) = self.came[index];
                    self.fill(bank as usize, line, now + 1, calendar);
                }
                self.came.clear();
            }
        }
        None
    }

    /// The first of the bank's out queue goes to the DRAM, if that has room.
    fn send(&mut self, index: usize, now: u64, calendar: &mut Calendar) {
        let Self { due, first, dram, banks, .. } = self;
        let mut alarm = Alarm { calendar, first: *first, due };
        let out = &mut banks[index].out;
        let Some(&request) = out.front() else { return };
        if dram.put(request, now, &mut alarm) {
            out.pop_front();
            if !out.is_empty() {
                alarm.wake(PartId(index as u32), now + 1);
            }
        }
    }

    /// A line is put into the bank in cycle `at`.
    fn fill(&mut self, index: usize, line: LineAddr, at: u64, calendar: &mut Calendar) {
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.clear();
        if let Fill::Done { victim: Some(victim) } = self.banks[index].cache.fill(line, true, &mut waiting) {
            let (bytes, from) = (self.line, PartId(index as u32));
            let Victim { line, class, .. } = victim;
            let write = Request { line, class, write: true, bytes, from, marked: false };
            self.banks[index].out.push_back(write);
            self.wake(index as u32, at, calendar);
        }
        waiting.iter().for_each(|&unit| self.answer(index, unit, line, at, calendar));
        self.waiting = waiting;
        // A register is free: those behind the one that stalled go on, each a cycle later.
        while let Some(request) = self.banks[index].stalled.pop_front() {
            let left = self.banks[index].stalled.len();
            self.access(index, request, at, calendar);
            if self.banks[index].stalled.len() > left {
                break;
            }
        }
    }

    /// The L2's tags hold from now on what `banks` do.
    pub fn hold(&mut self, banks: &[Cache]) {
        self.banks.iter_mut().zip(banks).for_each(|(bank, cache)| bank.cache.hold(cache));
    }

    /// A frame begins: lines from `first` on go.
    pub fn drop_from(&mut self, first: LineAddr) {
        self.banks.iter_mut().for_each(|bank| bank.cache.drop_from(first));
    }

    /// Whether nothing is under way.
    pub fn is_idle(&self) -> bool {
        self.dram.is_idle()
            && self.banks.iter().all(|bank| bank.out.is_empty() && bank.cache.misses_under_way() == 0)
            && self.answers.len() == self.free_answers.len()
    }

    /// What the banks counted.
    pub fn banks(&self) -> Vec<BankTally> {
        let tally = |bank: &Bank| BankTally { cache: *bank.cache.counts(), served: bank.served.clone() };
        self.banks.iter().map(tally).collect()
    }

    /// What the channels counted in a run of `cycles`.
    pub fn channels(&self, cycles: u64) -> Vec<ChannelTally> {
        let tally = |index| ChannelTally {
            counts: *self.dram.counts(index),
            moved: *self.dram.moved(index),
            refresh_due: self.dram.refresh_is_due(index, cycles - 1),
        };
        (0..self.dram.channels()).map(tally).collect()
    }
}
