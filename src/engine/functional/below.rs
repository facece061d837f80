//! What lies below the L1s: the L2's banks, each taking one access a cycle, in front of the machine's own model of the DRAM.

use std::collections::{BTreeSet, VecDeque};

use super::calendar::Calendar;
use crate::engine::tally::{BankTally, ChannelTally};
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
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
    /// Requests that wait, the first for a register, a target or a place in the out queue, and how many can.
    queue: VecDeque<Request>,
    places: usize,
    /// Units whose first request waits for a place in the queue.
    blocked: BTreeSet<u32>,
    out: VecDeque<Request>,
    served: Served,
}

impl Bank {
    /// Whether there is a place in the queue.
    fn takes(&self) -> bool {
        self.queue.len() < self.places
    }
}

/// An L1 as seen from here.
#[derive(Clone, Debug)]
struct L1 {
    /// Its out queue: requests that no bank has taken, the banks they are for, and how many there can be.
    out: VecDeque<(usize, Request)>,
    places: usize,
    /// When lines come to it that are on their way.
    coming: Vec<u64>,
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
    /// Unit by unit.
    l1s: Vec<L1>,
    /// Units that can send another request.
    pub got_room: Vec<u32>,
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
            queue: VecDeque::new(),
            places: spec.queue.size(),
            blocked: BTreeSet::new(),
            out: VecDeque::new(),
            served: Served::default(),
        };
        let l1 = |kind: Kind| {
            let spec = kind.spec(machine);
            vec![L1 { out: VecDeque::new(), places: spec.cache.queue.size(), coming: Vec::new() }; spec.count as usize]
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
            l1s: Kind::ALL.into_iter().flat_map(l1).collect(),
            got_room: Vec::new(),
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
        let (unit, takes) = (request.from.0, self.banks[index].takes());
        let out = &mut self.l1s[unit as usize].out;
        if out.is_empty() && takes {
            return self.put(index, request, at, calendar);
        }
        if out.is_empty() {
            self.banks[index].blocked.insert(unit);
        }
        out.push_back((index, request));
    }

    /// Whether a unit's L1 could send a request.
    pub fn has_room(&self, PartId(unit): PartId) -> bool {
        let l1 = &self.l1s[unit as usize];
        l1.out.len() < l1.places
    }

    /// Whether a line comes to a unit up to cycle `at`, as far as is known.
    #[inline]
    pub fn comes_by(&self, unit: usize, at: u64) -> bool {
        self.l1s[unit].coming.iter().any(|&comes| comes <= at)
    }

    fn put(&mut self, index: usize, request: Request, at: u64, calendar: &mut Calendar) {
        if self.banks[index].queue.is_empty() {
            self.access(index, request, at + 1, calendar);
        } else {
            self.banks[index].queue.push_back(request);
        }
    }

    fn access(&mut self, index: usize, request: Request, at: u64, calendar: &mut Calendar) {
        let bank = &mut self.banks[index];
        let at = at.max(bank.free_at);
        let Request { line, class, write, bytes, from, marked } = request;
        let (access, reader) = if write { (Access::Write, None) } else { (Access::Read, Some(from.0)) };
        let room = bank.out.len() < bank.places;
        let lookup = bank.cache.access(line, class, access, reader, room);
        match lookup {
            Lookup::Stalled => return bank.queue.push_front(request),
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
        let at = at + self.banks[bank].latency + 1;
        self.l1s[unit as usize].coming.push(at);
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
        calendar.put(at, self.first + self.due.len() as u32 + place);
    }

    /// An event of this memory in cycle `now`; a line that comes to an L1, if it is one.
    pub fn event(&mut self, event: u32, now: u64, calendar: &mut Calendar) -> Option<Answer> {
        let part = (event - self.first) as usize;
        match part.checked_sub(self.due.len()) {
            Some(place) => {
                self.free_answers.push(place as u32);
                let answer = self.answers[place];
                let coming = &mut self.l1s[answer.unit as usize].coming;
                let came = coming.iter().position(|&at| at == now).expect("a line comes when it was announced");
                coming.swap_remove(came);
                return Some(answer);
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
            self.go_on(index, now + 1, calendar);
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
        self.go_on(index, at, calendar);
    }

    /// A register or a place in the out queue is free: requests that wait go on, each a cycle later, and so do those of units that wait for
    /// their places.
    fn go_on(&mut self, index: usize, at: u64, calendar: &mut Calendar) {
        while let Some(request) = self.banks[index].queue.pop_front() {
            let left = self.banks[index].queue.len();
            self.access(index, request, at, calendar);
            if self.banks[index].queue.len() > left {
                break;
            }
        }
        while self.banks[index].takes()
            && let Some(unit) = self.banks[index].blocked.pop_first()
        {
            let out = &mut self.l1s[unit as usize].out;
            let (_, request) = out.pop_front().expect("who waits for a place has a request");
            let next = out.front().map(|&(next, _)| next);
            self.got_room.push(unit);
            self.put(index, request, at, calendar);
            if let Some(next) = next {
                self.banks[next].blocked.insert(unit);
                if next != index && self.banks[next].takes() {
                    self.go_on(next, at + 1, calendar);
                }
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
            && self
                .banks
                .iter()
                .all(|bank| bank.out.is_empty() && bank.queue.is_empty() && bank.cache.misses_under_way() == 0)
            && self.answers.len() == self.free_answers.len()
    }

    /// The state of the queues, for the report of a deadlock.
    pub fn queues(&self) -> String {
        let sum = |of: fn(&Bank) -> usize| self.banks.iter().map(of).sum::<usize>();
        format!(
            "sent by L1s and not taken {}, waiting in banks of the L2 {}, misses under way {}, out to the DRAM {}",
            self.l1s.iter().map(|l1| l1.out.len()).sum::<usize>(),
            sum(|bank| bank.queue.len()),
            sum(|bank| bank.cache.misses_under_way()),
            sum(|bank| bank.out.len()),
        )
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
