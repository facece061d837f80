//! The functional rung: real tags, miss registers and DRAM, units that are no more than times from which on they are free. Rays
//! in flight are limited as in the machine, and a ray's step is one event (two, if it waits for a line): so accesses come in an
//! order close to the machine's, and time falls out of what is busy when.
//!
//! What is left out of MODEL.md's rules: a fill never waits, requests that wait in a bank are accessed together, and of what happens in one
//! cycle mostly the order of announcement counts.

mod below;
mod calendar;
mod ray;
mod station;

use self::below::{Answer, Below};
use self::calendar::Calendar;
use self::ray::{Ray, Stage};
use self::station::{Fetch, Fetched, Station};
use super::crossing::{Crossing, Taken};
use super::dispatch::{Dispatch, Given};
use super::feed::Feed;
use super::tally::{Tally, busy};
use super::work::{Holder, Work};
use super::{Engine, RunError, patience};
use crate::machine::MachineSpec;
use crate::machine::division::DivisionSpec;
use crate::machine::kinds::Kind;
use crate::machine::layout::{Element, Layout};
use crate::memory::dram::command::ChannelLog;
use crate::memory::{PartId, Request};
use crate::quantity::{Bytes, LineAddr};
use crate::stream::{Header, Step};

/// The machine, simplified.
pub(super) struct Functional {
    division: DivisionSpec,
    cores: usize,
    line: Bytes,
    layout: Layout,
    pub(super) dispatch: Dispatch,
    /// The pool, then the entries for steps of a frame's end.
    rays: Vec<Ray>,
    /// Units, as the crossing numbers them.
    stations: Vec<Station>,
    crossing: Crossing,
    /// Of each division unit, when it can begin the next operation, and how many it began.
    divisions: Vec<(u64, u64)>,
    below: Below,
    calendar: Calendar,
    /// Whether the end of shading is in the calendar.
    shading: bool,
    waiting: Vec<u32>,
    /// Cycles in which a ray or a unit must act.
    patience: u64,
}

impl Functional {
    pub(super) fn new(machine: &MachineSpec, header: &Header) -> Self {
        let line = machine.line_bytes.get();
        let cores = machine.cores.size();
        let of_kind = |kind: Kind| {
            let spec = kind.spec(machine);
            vec![Station::new(&spec, line); spec.count as usize]
        };
        let dispatch = Dispatch::new(machine);
        let flights = dispatch.flights.len();
        let stations: Vec<Station> = Kind::ALL.into_iter().flat_map(of_kind).collect();
        // Events: rays, the end of shading, units, then what is below.
        let first_below = (flights + 1 + stations.len()) as u32;
        Self {
            division: machine.division,
            cores,
            divisions: vec![(0, 0); cores * machine.division.count.size()],
            line: Bytes(line),
            layout: Layout::new(header, machine),
            rays: vec![Ray::IDLE; flights],
            dispatch,
            stations,
            crossing: Crossing::new(machine),
            below: Below::new(machine, first_below),
            calendar: Calendar::new(),
            shading: false,
            waiting: Vec::new(),
            patience: patience(machine),
        }
    }

    /// The event at which parents' shading ends.
    fn shading_ends(&self) -> u32 {
        self.rays.len() as u32
    }

    /// The shadow-cache unit of a ray's next step: the home of its entry, or by the ray's number.
    fn shadow_cache(&self, id: u32) -> usize {
        let units = self.crossing.of_kind(Kind::ShadowCache);
        let step = self.dispatch.flights[id as usize].step(Holder::ShadowCache);
        let entry = step.filter(|_| !self.rays[id as usize].undecided).and_then(Step::entry);
        let number = entry.map_or(u64::from(id), |(store, index)| self.layout.line_of(store, index).0);
        units.start + (number % units.len() as u64) as usize
    }

    /// What a ray does in cycle `now`.
    fn ray(&mut self, id: u32, now: u64) {
        let ray = &self.rays[id as usize];
        let station = ray.station as usize;
        match ray.stage {
            Stage::Ready => {
                self.stations[station].ready -= 1;
                self.begin(id, station, now);
            }
            Stage::Step => self.step(id, now),
            Stage::Second => {
                let second = self.work(id).second.expect("a second operation has something to fetch");
                self.rays[id as usize].operations_left = 0;
                self.fetch(id, station, &second, now);
            }
            Stage::Back => {
                self.crossing.leave(station, now);
                self.step(id, now);
            }
            Stage::Policy => self.crossing.arrive(id, self.shadow_cache(id), now),
        }
        self.take_on_all();
    }

    /// What the ray's step asks for.
    fn work(&self, id: u32) -> Work {
        let (flight, holder) = (&self.dispatch.flights[id as usize], self.rays[id as usize].holder);
        let step = flight.step(holder).expect("a ray that works has a step");
        Work::of(step, holder, flight.kind, &self.layout)
    }

    /// The holder looks at the ray's next step.
    fn step(&mut self, id: u32, now: u64) {
        let (ray, flight) = (&mut self.rays[id as usize], &self.dispatch.flights[id as usize]);
        let Some(step) = flight.step(ray.holder) else {
            return match ray.holder {
                Holder::Traversal => self.retire(id, now),
                Holder::ShadowCache => self.leave_policy(id, now),
            };
        };
        let work = Work::of(step, ray.holder, flight.kind, &self.layout);
        (ray.operations_left, ray.divides) = (work.second.is_some().into(), work.divides);
        let from = match ray.holder {
            Holder::Traversal => flight.unit as usize,
            Holder::ShadowCache => {
                let (unit, home) = (ray.policy_unit as usize, self.shadow_cache(id));
                if step.entry().is_some() && home != unit {
                    self.crossing.leave(unit, now + 1);
                    return self.crossing.arrive(id, home, now + 1);
                }
                unit
            }
        };
        let away = work.kind != self.rays[id as usize].holder.kind();
        self.rays[id as usize].away = away;
        if !away {
            self.fetch(id, from, &work.first, now);
        } else {
            let home = (id as usize).checked_sub(self.dispatch.pool()).unwrap_or(id as usize);
            self.crossing.send(id, from, self.crossing.performer(work.kind, from, home), now);
        }
    }

    /// Units work on the rays that they have taken on.
    fn take_on_all(&mut self) {
        while let Some(Taken { ray, unit, at }) = self.crossing.taken() {
            self.take_on(ray, unit, at);
        }
    }

    fn take_on(&mut self, id: u32, station: usize, at: u64) {
        self.rays[id as usize].station = station as u32;
        if self.crossing.kind(station) != Kind::ShadowCache {
            let first = self.work(id).first;
            return self.fetch(id, station, &first, at);
        }
        let ray = &mut self.rays[id as usize];
        (ray.holder, ray.policy_unit) = (Holder::ShadowCache, station as u32);
        if ray.undecided {
            (ray.operations_left, ray.fetch.write) = (0, false);
            self.begin(id, station, at);
        } else {
            self.step(id, at);
        }
    }

    fn fetch(&mut self, id: u32, station: usize, element: &Element, at: u64) {
        let (line, lines) = self.layout.lines(element);
        let ray = &mut self.rays[id as usize];
        ray.station = station as u32;
        ray.fetch = Fetch {
            line,
            left: lines as u32,
            missing: 0,
            write: element.write,
            class: element.class,
            bytes: element.bytes as u32,
            marked: self.dispatch.flights[id as usize].marked,
            data_at: at,
        };
        if !self.stations[station].is_free(at) || !self.access(id, station, at) {
            self.stations[station].fetching.push_back(id);
            self.announce(station, at);
        }
    }

    /// A unit whose ports someone waits for acts when they are free.
    fn announce(&mut self, station: usize, now: u64) {
        let unit = &mut self.stations[station];
        if !unit.is_announced
            && let Some(at) = unit.acts_at(now)
        {
            unit.is_announced = true;
            self.calendar.put(at, self.shading_ends() + 1 + station as u32);
        }
    }

    /// Those who wait for a unit's ports get them in cycle `now`.
    fn use_ports(&mut self, station: usize, now: u64) {
        self.stations[station].is_announced = false;
        if let Some(id) = self.stations[station].release(now) {
            self.got_line(id, station, now);
        }
        while self.stations[station].acts_at(now) == Some(now)
            && let Some(&id) = self.stations[station].fetching.front()
            && self.access(id, station, now)
        {
            self.stations[station].fetching.pop_front();
        }
        self.announce(station, now);
    }

    /// Goes on with a ray's fetch; false if it stalled.
    fn access(&mut self, id: u32, station: usize, at: u64) -> bool {
        let core = self.crossing.core(station);
        let Self { rays, stations, below, calendar, line, .. } = self;
        let fetch = &mut rays[id as usize].fetch;
        let Fetch { class, marked, .. } = *fetch;
        let (bytes, from) = (*line, PartId(station as u32));
        let room = below.has_room(from);
        let fetched = stations[station].access(id, fetch, at, room, |line, at| {
            below.request(core, Request { line, class, write: false, bytes, from, marked }, at, calendar);
            below.has_room(from)
        });
        match fetched {
            Fetched::At(at) => self.ready(id, station, at),
            Fetched::Waits => {}
            Fetched::Stalled => {
                self.stations[station].stalled = true;
                return false;
            }
        }
        true
    }

    /// An event of the memory in cycle `now`; whether a unit gets anything by it.
    fn memory(&mut self, event: u32, now: u64) -> bool {
        let answer = self.below.event(event, now, &mut self.calendar);
        let mut gets = answer.is_some();
        if let Some(answer) = answer {
            self.line_came(answer, now);
        }
        while let Some(unit) = self.below.got_room.pop() {
            self.stations[unit as usize].stalled = false;
            self.announce(unit as usize, now);
            gets = true;
        }
        gets
    }

    /// A line comes to a unit's L1.
    fn line_came(&mut self, Answer { unit, line }: Answer, now: u64) {
        let station = unit as usize;
        let mut waiting = std::mem::take(&mut self.waiting);
        waiting.clear();
        if let Some((line, class)) = self.stations[station].fill(line, &mut waiting) {
            let (bytes, from) = (self.line, PartId(unit));
            let request = Request { line, class, write: true, bytes, from, marked: false };
            self.below.request(self.crossing.core(station), request, now, &mut self.calendar);
        }
        waiting.iter().for_each(|&id| self.got_line(id, station, now));
        self.waiting = waiting;
        self.announce(station, now);
    }

    /// A line that the ray waits for is there.
    fn got_line(&mut self, id: u32, station: usize, now: u64) {
        let fetch = &mut self.rays[id as usize].fetch;
        fetch.missing -= 1;
        if fetch.missing == 0 && fetch.left == 0 {
            if fetch.data_at > now {
                let at = fetch.data_at;
                self.ready(id, station, at);
            } else {
                self.begin(id, station, now);
            }
        }
    }

    /// The data are there from cycle `at` on. Operations begin in the order in which their data come, which decides what rays find in the L1: if a line comes
    /// until then, those who wait for it begin before.
    fn ready(&mut self, id: u32, station: usize, at: u64) {
        let unit = &mut self.stations[station];
        if unit.ready > 0 || self.below.comes_by(station, at) {
            unit.ready += 1;
            self.rays[id as usize].stage = Stage::Ready;
            self.calendar.put(at, id);
        } else {
            self.begin(id, station, at);
        }
    }

    /// The operation begins as soon as it can from cycle `at` on, and what follows is announced.
    fn begin(&mut self, id: u32, station: usize, at: u64) {
        let (begin, core) = (self.stations[station].operate(at), self.crossing.core(station));
        let ray = &mut self.rays[id as usize];
        if ray.fetch.write && self.stations[station].writes.go_through(ray.fetch.class) {
            // The fetch has moved on past the one line that an entry of a store lies in.
            let (line, class) = (LineAddr(ray.fetch.line.0 - 1), ray.fetch.class);
            let bytes = Bytes(ray.fetch.bytes.into());
            self.stations[station].write_through(class, bytes);
            let from = PartId(station as u32);
            let request = Request { line, class, write: true, bytes, from, marked: false };
            self.below.request(core, request, begin, &mut self.calendar);
        }
        let unit = &mut self.stations[station];
        let mut at = unit.end(begin);
        ray.stage = Stage::Step;
        if ray.undecided && ray.holder == Holder::ShadowCache {
            ray.undecided = false;
        } else if ray.operations_left > 0 {
            ray.stage = Stage::Second;
        } else {
            if ray.divides {
                let a_core = self.divisions.len() / self.cores;
                let (open_at, begun) = &mut self.divisions[core * a_core + id as usize % a_core];
                let begin = at.max(*open_at);
                (*open_at, *begun) = (begin + self.division.interval.get(), *begun + 1);
                at = begin + self.division.latency.get();
            }
            if ray.away {
                (ray.stage, at) = (Stage::Back, at + 1);
            }
            self.dispatch.performed(id);
        }
        self.calendar.put(at, id);
    }

    /// The ray's path is done.
    fn retire(&mut self, id: u32, now: u64) {
        self.dispatch.left_slot(id);
        if self.dispatch.flights[id as usize].has_policy() {
            self.rays[id as usize].stage = Stage::Policy;
            self.calendar.put(now + 1, id);
        } else {
            self.done(id, now);
        }
    }

    /// The ray's policy steps are done, or a step of the frame's end is.
    fn leave_policy(&mut self, id: u32, now: u64) {
        self.crossing.leave(self.rays[id as usize].policy_unit as usize, now + 1);
        self.done(id, now);
    }

    fn done(&mut self, id: u32, now: u64) {
        self.dispatch.done(id, now);
        self.await_shading();
    }

    fn await_shading(&mut self) {
        if !self.shading
            && let Some(at) = self.dispatch.next_shaded()
        {
            self.shading = true;
            self.calendar.put(at, self.shading_ends());
        }
    }

    /// Hands out rays from cycle `at` on as long as there are rays and places for them, and goes on in the stream.
    fn dispatch<E>(&mut self, at: u64, feed: &mut impl Feed<E>) -> Result<(), RunError<E>> {
        self.hand_out_all(at, feed)?;
        if feed.marks() {
            let tally = self.tally(at + 1);
            if let Some(warm) = feed.mark(&tally) {
                let l1s = Kind::ALL.into_iter().flat_map(|kind| warm.l1s(kind));
                self.stations.iter_mut().zip(l1s).for_each(|(station, l1)| station.hold(l1));
                self.below.hold(warm.banks());
            }
        }
        Ok(())
    }

    fn hand_out_all<E>(&mut self, at: u64, feed: &mut impl Feed<E>) -> Result<(), RunError<E>> {
        while let Some(given) = self.dispatch.next(at, feed, &mut self.layout)? {
            let (id, at, holder, stage) = match given {
                Given::Frame => {
                    let first = self.layout.dynamic_part();
                    self.stations.iter_mut().for_each(|station| station.drop_from(first));
                    self.below.drop_from(first);
                    continue;
                }
                Given::Traced(id, at) => (id, at, Holder::Traversal, Stage::Step),
                Given::Skipped(id, at) | Given::Ending(id, at) => (id, at, Holder::ShadowCache, Stage::Policy),
            };
            let ray = &mut self.rays[id as usize];
            (ray.holder, ray.stage, ray.undecided) = (holder, stage, matches!(given, Given::Skipped(..)));
            self.calendar.put(at, id);
        }
        Ok(())
    }

    fn is_over(&self) -> bool {
        self.dispatch.is_over()
            && self.below.is_idle()
            && self.stations.iter().all(|station| station.misses_under_way() == 0)
    }
}

impl Engine for Functional {
    fn run<E>(&mut self, feed: &mut impl Feed<E>) -> Result<u64, RunError<E>> {
        let mut events = Vec::new();
        self.below.begin(&mut self.calendar);
        self.dispatch(0, feed)?;
        let (rays, shading_ends) = (self.rays.len() as u32, self.shading_ends());
        let stations = self.stations.len() as u32;
        // The DRAM's refresh never ends: that something happens does not say that anything goes on.
        let mut acted_at = 0;
        while let Some(now) = self.calendar.turn(&mut events).filter(|now| now - acted_at <= self.patience) {
            for &event in &events {
                let acts = if event < rays {
                    self.ray(event, now);
                    true
                } else if event == shading_ends {
                    self.shading = false;
                    self.dispatch.shaded(now);
                    self.await_shading();
                    true
                } else if event <= shading_ends + stations {
                    self.use_ports((event - shading_ends - 1) as usize, now);
                    true
                } else {
                    self.memory(event, now)
                };
                if acts {
                    acted_at = now;
                }
            }
            if std::mem::take(&mut self.dispatch.freed) {
                self.dispatch(now + 1, feed)?;
            }
            if self.is_over() {
                return Ok(now + 1);
            }
        }
        let queues = format!("rays in flight {}, {}", self.dispatch.in_flight(), self.below.queues());
        Err(RunError::Deadlock { cycle: acted_at, queues })
    }

    fn tally(&self, cycles: u64) -> Tally {
        let units = |kind| self.stations[self.crossing.of_kind(kind)].iter().map(Station::tally).collect();
        Tally {
            cycles,
            rays: self.dispatch.rays_done,
            dispatcher: busy(self.dispatch.busy),
            units: Kind::ALL.map(units),
            divisions: self.divisions.iter().map(|&(_, begun)| busy(begun * self.division.interval.get())).collect(),
            banks: self.below.banks(),
            channels: self.below.channels(cycles),
            ..Tally::default()
        }
    }

    fn logs(&mut self) -> Vec<&mut ChannelLog> {
        Vec::new()
    }
}
