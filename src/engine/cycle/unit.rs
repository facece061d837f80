//! Common parts of traversal, list, intersection and shadow-cache units: steps 1 to 7 of their cycles.

use std::collections::{BTreeMap, VecDeque};

use super::cache::{Cache, LineAccess, Lookup};
use super::ray::Id;
use super::request::Request;
use super::wires::Wires;
use crate::engine::tally::UnitTally;
use crate::machine::layout::{Element, Layout};
use crate::machine::writes::WritePolicy;
use crate::memory::cache::{CacheSpec, Release};
use crate::quantity::{Bytes, LineAddr};
use crate::stats::Cause;

/// A fetch under way.
#[derive(Clone, Debug)]
struct Fetch {
    element: Element,
    /// Lines that are not accessed yet.
    to_access: VecDeque<LineAddr>,
    /// Accessed lines that have not come.
    to_come: usize,
    /// Whether the fetch bypasses the L1.
    bypass_l1: bool,
}

/// Latency of an operation, cycles from one to the next, and how many can begin in one cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    pub latency: u64,
    pub interval: u64,
    pub width: u64,
}

/// The unit.
#[derive(Clone, Debug)]
pub(super) struct Unit {
    /// The number of its L1.
    l1: usize,
    spec: CacheSpec,
    pace: Pace,
    last_began: Option<u64>,
    line: u64,
    writes: WritePolicy,
    cache: Cache<Id>,
    out: VecDeque<Request>,
    /// Fetches of all rays that access or wait for lines.
    fetches: BTreeMap<Id, Fetch>,
    fetch_queue: VecDeque<Id>,
    hits: VecDeque<(u64, Id)>,
    /// Rays with all their data, and the element fetched.
    ready: VecDeque<(Id, Option<Element>)>,
    stages: VecDeque<(u64, Id)>,
    /// Rays whose line has come and that get it one by one (`Release::OneByOne`).
    in_rows: VecDeque<Id>,
    /// Reads that bypass the L1, oldest first: the line and the ray.
    asked: Vec<(LineAddr, Id)>,
    pub tally: UnitTally,
}

impl Unit {
    pub(super) fn new(l1: usize, spec: &CacheSpec, pace: Pace, line: u64, writes: WritePolicy) -> Self {
        Self {
            l1,
            spec: *spec,
            pace,
            last_began: None,
            line,
            writes,
            cache: Cache::new(spec.tags(line), spec.no_allocate, spec.mshrs.size(), spec.targets.size()),
            out: VecDeque::new(),
            fetches: BTreeMap::new(),
            fetch_queue: VecDeque::new(),
            hits: VecDeque::new(),
            ready: VecDeque::new(),
            stages: VecDeque::new(),
            in_rows: VecDeque::new(),
            asked: Vec::new(),
            tally: UnitTally::default(),
        }
    }

    fn out_has_room(&self) -> bool {
        self.out.len() < self.spec.queue.size()
    }

    /// A ray begins to fetch `element`.
    pub(super) fn fetch(&mut self, id: Id, element: Element, layout: &Layout) {
        let (first, count) = layout.lines(&element);
        let to_access = (0..count).map(|line| LineAddr(first.0 + line)).collect();
        self.fetches.insert(id, Fetch { element, to_access, to_come: 0, bypass_l1: false });
        self.fetch_queue.push_back(id);
    }

    /// A ray begins to fetch `element` from the L2, bypassing the L1.
    pub(super) fn fetch_bypass(&mut self, id: Id, element: Element, layout: &Layout) {
        self.fetch(id, element, layout);
        self.fetches.entry(id).and_modify(|fetch| fetch.bypass_l1 = true);
    }

    /// Makes a ray ready for an operation on `element` without a fetch.
    pub(super) fn ready_with(&mut self, id: Id, element: Element) {
        self.ready.push_back((id, Some(element)));
    }

    /// Makes a ray ready for an operation without data.
    pub(super) fn ready_without_fetch(&mut self, id: Id) {
        self.ready.push_back((id, None));
    }

    /// Steps 1 and 2.
    pub(super) fn fill_and_hit(&mut self, now: u64, wires: &mut Wires) {
        let lines = &mut wires.to_l1[self.l1];
        if let Some(&line) = lines.first(now)
            && let Some(oldest) = self.asked.iter().position(|&(asked, _)| asked == line)
        {
            lines.take(now);
            let (_, id) = self.asked.remove(oldest);
            self.line_came(id);
        } else if let Some(&line) = lines.first(now)
            && let Some(filled) = self.cache.fill(line, self.out_has_room())
        {
            lines.take(now);
            if let Some(victim) = filled.dirty_victim {
                let bytes = Bytes(self.line);
                self.out.push_back(Request {
                    line: victim.line,
                    class: victim.class,
                    write: true,
                    bytes,
                    from: self.l1,
                });
            }
            match self.spec.release {
                Release::Together => filled.waited.into_iter().for_each(|id| self.line_came(id)),
                Release::OneByOne => self.in_rows.extend(filled.waited),
            }
        }
        while let Some(&(at, id)) = self.hits.front()
            && at <= now
        {
            self.hits.pop_front();
            self.line_came(id);
        }
    }

    fn line_came(&mut self, id: Id) {
        let fetch = self.fetches.get_mut(&id).expect("who waits for a line has a fetch under way");
        fetch.to_come -= 1;
        if fetch.to_come == 0 && fetch.to_access.is_empty() {
            self.ready.push_back((id, Some(fetch.element)));
            self.fetches.remove(&id);
        }
    }

    /// Step 3: returns the ray whose operation ends.
    pub(super) fn leave(&mut self, now: u64) -> Option<Id> {
        let &(_, id) = self.stages.front().filter(|&&(at, _)| at == now)?;
        self.stages.pop_front();
        Some(id)
    }

    /// Step 5: returns whether operations began.
    pub(super) fn begin(&mut self, now: u64, layout: &Layout) -> bool {
        if self.is_occupied(now) {
            return false;
        }
        let began = (0..self.pace.width).take_while(|_| self.begin_one(now, layout)).count();
        self.tally.operations += began as u64;
        if began > 0 {
            self.last_began = Some(now);
        }
        began > 0
    }

    /// Begins the operation of the first ready ray, if the output queue has a place for its write-through.
    fn begin_one(&mut self, now: u64, layout: &Layout) -> bool {
        let Some(&(id, element)) = self.ready.front() else { return false };
        if let Some(element) = element.filter(|element| element.write && self.writes.go_through(element.class)) {
            if !self.out_has_room() {
                return false;
            }
            let (line, _) = layout.lines(&element);
            let bytes = Bytes(element.bytes);
            self.out.push_back(Request { line, class: element.class, write: true, bytes, from: self.l1 });
            self.tally.written_through[element.class as usize].count += 1;
            self.tally.written_through[element.class as usize].bytes += bytes;
        }
        self.ready.pop_front();
        self.stages.push_back((now + self.pace.latency, id));
        true
    }

    /// Whether an earlier operation prevents others from beginning in cycle `now`.
    fn is_occupied(&self, now: u64) -> bool {
        self.last_began.is_some_and(|began| now - began < self.pace.interval)
    }

    /// Step 6.
    pub(super) fn access(&mut self, now: u64) {
        if let Some(id) = self.in_rows.pop_front() {
            return self.line_came(id);
        }
        let mut banks_in_use = Vec::new();
        for _ in 0..self.spec.ports.get() {
            let Some(&id) = self.fetch_queue.front() else { return };
            let room = self.out_has_room();
            let Some(Fetch { element, to_access, to_come, bypass_l1 }) = self.fetches.get_mut(&id) else {
                unreachable!("a ray of the fetch queue has a fetch under way")
            };
            let line = to_access[0];
            if *bypass_l1 {
                if !room || self.asked.len() == self.spec.mshrs.size() {
                    return;
                }
                let (class, bytes) = (element.class, Bytes(element.bytes));
                self.out.push_back(Request { line, class, write: false, bytes, from: self.l1 });
                self.asked.push((line, id));
                self.tally.bypassed[class as usize].count += 1;
                self.tally.bypassed[class as usize].bytes += bytes;
                to_access.clear();
                *to_come = 1;
                self.fetch_queue.pop_front();
                continue;
            }
            let &mut Element { class, write, .. } = element;
            if let Some(banks) = self.spec.banks {
                let bank = line.0 % banks.get();
                if banks_in_use.contains(&bank) {
                    self.tally.l1[class as usize].bank_conflicts += 1;
                    return;
                }
                banks_in_use.push(bank);
            }
            let dirties = write && !self.writes.go_through(class);
            match self.cache.access(LineAccess { line, class, write, dirties, needs_data: true }, room, id) {
                Lookup::Stop => return,
                Lookup::WriteAround => unreachable!("a ray waits for the data"),
                Lookup::Hit => self.hits.push_back((now + self.spec.latency.get(), id)),
                Lookup::MshrHit => {}
                Lookup::Miss => {
                    let (class, bytes) = (element.class, Bytes(self.line));
                    self.out.push_back(Request { line, class, write: false, bytes, from: self.l1 });
                }
            }
            to_access.pop_front();
            *to_come += 1;
            if to_access.is_empty() {
                self.tally.requested[element.class as usize] += Bytes(element.bytes);
                self.fetch_queue.pop_front();
            }
        }
    }

    /// Step 7.
    pub(super) fn send(&mut self, now: u64, wires: &mut Wires) {
        let Some(&request) = self.out.front() else { return };
        let bank = wires.bank_of(&request);
        if bank.has_room() {
            bank.put(now, request);
            self.out.pop_front();
        }
    }

    /// Accounts the cycle to a cause. `began`: an operation began in step 5. `leaving`: a ray waits to go to another
    /// unit. `passed_by`: rays wait because the unit took on its maximum.
    pub(super) fn account(&mut self, now: u64, began: bool, leaving: bool, passed_by: bool) {
        let memory = !self.fetches.is_empty();
        let pipeline = !self.stages.is_empty();
        let blocked = leaving || !self.ready.is_empty();
        let cause = if began || self.is_occupied(now) {
            Cause::Busy
        } else if passed_by {
            Cause::Intake
        } else if !(memory || pipeline || blocked) {
            Cause::Starved
        } else if blocked {
            Cause::Blocked
        } else if memory {
            Cause::Memory
        } else {
            Cause::Pipeline
        };
        self.tally.causes[cause as usize] += 1;
    }

    /// A frame begins: drops lines from `first` on.
    pub(super) fn drop_from(&mut self, first: LineAddr) {
        self.cache.drop_from(first);
    }

    /// Whether no line is on its way to or from memory.
    pub(super) fn memory_is_empty(&self) -> bool {
        self.out.is_empty() && self.cache.on_their_way() == 0 && self.asked.is_empty()
    }

    /// Misses of its L1 under way.
    pub(super) fn misses_under_way(&self) -> usize {
        self.cache.on_their_way()
    }

    /// Counts of the unit and of its L1.
    pub(super) fn tally(&self) -> UnitTally {
        UnitTally { cache: self.cache.counts, ..self.tally.clone() }
    }

    /// The state of the queues, for the report of a deadlock.
    pub(super) fn queues(&self) -> String {
        format!(
            "to fetch {}, fetches under way {}, ready {}, in the pipeline {}, misses under way {}, out {}/{}",
            self.fetch_queue.len(),
            self.fetches.len(),
            self.ready.len(),
            self.stages.len(),
            self.cache.on_their_way(),
            self.out.len(),
            self.spec.queue
        )
    }
}
