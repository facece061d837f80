//! The simplified machine.

use super::agenda::Agenda;
use super::dispatch::{Dispatch, Given};
use super::entries::EntryAccess;
use super::issue_queues::{IssueQueues, Taken};
use super::memory::Memory;
use super::port::Port;
use super::unit::Unit;
use super::watch::Watch;
use super::whereabouts::{Stage, Way, Whereabouts};
use crate::engine::contract::Engine;
use crate::engine::error::RunError;
use crate::engine::feed::Feed;
use crate::engine::tally::{Tally, busy};
use crate::engine::work::{Holder, Work};
use crate::machine::MachineSpec;
use crate::machine::division::DivisionSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::machine::layout::{Element, Layout};
use crate::machine::shadow_cache::Place;
use crate::memory::dram::command::ChannelLog;
use crate::stream::{Header, Step};

/// The simplified machine.
pub(crate) struct Profile<W = ()> {
    division: DivisionSpec,
    /// Where the policy's stores are placed, which decides how accesses go.
    place: Place,
    cores: usize,
    layout: Layout,
    pub dispatch: Dispatch,
    rays: Vec<Whereabouts>,
    /// Units, as the issue_queues numbers them.
    units: Vec<Unit>,
    issue_queues: IssueQueues,
    /// For each division unit: when it can begin the next operation, and its number of operations.
    divisions: Vec<(u64, u64)>,
    memory: Memory<W>,
    /// The host's port to the DRAM.
    port: Option<Port>,
    agenda: Agenda,
    /// The cycles in which the last two frames were over. A run never ends before the earlier of them.
    frames_over: [u64; 2],
    /// Whether the end of shading is on the agenda, under the number after all rays.
    shading: bool,
}

impl Profile {
    pub(crate) fn new(machine: &MachineSpec, header: &Header) -> Self {
        Self::watched(machine, header, ())
    }
}

impl<W: Watch> Profile<W> {
    /// The machine; `watch` receives all accesses.
    pub(crate) fn watched(machine: &MachineSpec, header: &Header, watch: W) -> Self {
        let line = machine.line_bytes.get();
        let issue_queues = IssueQueues::new(machine);
        let of_kind = |kind: Kind| {
            let spec = kind.spec(machine);
            let writes = if kind == Kind::Intersection { machine.triangle_writes() } else { spec.writes };
            let spec = KindSpec { writes, ..spec };
            issue_queues
                .of_kind(kind)
                .map(|unit| Unit::new(&spec, unit, issue_queues.core(unit), line))
                .collect::<Vec<_>>()
        };
        let dispatch = Dispatch::new(machine, header);
        let rays = dispatch.flights.len();
        Self {
            division: machine.division,
            place: machine.shadow_cache.place,
            cores: machine.cores.size(),
            divisions: vec![(0, 0); machine.cores.size() * machine.division.count.size()],
            layout: Layout::new(header, machine),
            dispatch,
            rays: vec![Whereabouts::IDLE; rays],
            units: Kind::ALL.into_iter().flat_map(of_kind).collect(),
            issue_queues,
            memory: Memory::new(machine, watch),
            port: Port::new(machine),
            agenda: Agenda::new(rays + 1),
            frames_over: [0; 2],
            shading: false,
        }
    }

    /// The shadow-cache unit of a ray's next step: the owner of its entry, or by the ray's number.
    fn shadow_cache(&self, id: u32) -> usize {
        let units = self.issue_queues.of_kind(Kind::ShadowCache);
        if units.len() == 1 {
            return units.start;
        }
        let step = self.dispatch.flights[id as usize].step(Holder::ShadowCache);
        let entry = step.filter(|_| !self.rays[id as usize].undecided).and_then(Step::entry);
        let number = entry.map_or(u64::from(id), |(store, index)| self.layout.line_of(store, index).0);
        units.start + (number % units.len() as u64) as usize
    }

    /// The ray acts in cycle `now`.
    fn act(&mut self, id: u32, now: u64) {
        match self.rays[id as usize].stage {
            Stage::Step => self.step(id, now),
            Stage::First => self.first(id, now),
            Stage::Second => self.second(id, now),
            Stage::Back => {
                self.issue_queues.leave(self.rays[id as usize].away as usize, now);
                self.step(id, now);
            }
            Stage::Policy => self.issue_queues.arrive(id, self.shadow_cache(id), now),
            Stage::Entry => self.access(id, now),
        }
        self.take_on_all();
    }

    /// The ray's holder performs the next step or sends the ray on.
    fn step(&mut self, id: u32, now: u64) {
        let ray = &mut self.rays[id as usize];
        ray.stage = Stage::Step;
        if std::mem::take(&mut ray.fetched) {
            let end = self.units[ray.policy_unit as usize].decide(now);
            self.dispatch.performed(id);
            return self.agenda.put(end, id);
        }
        let flight = &self.dispatch.flights[id as usize];
        if ray.holder == Holder::Traversal
            && let Some(node) = flight.visit()
        {
            let (unit, watch) = (&mut self.units[flight.unit as usize], &mut self.memory.watch);
            watch.entry(id as usize, false);
            if let Some(end) = unit.visit(&self.layout.node(node), now, &self.layout, watch) {
                self.dispatch.performed(id);
                return self.agenda.put(end, id);
            }
        }
        let Some(step) = flight.step(ray.holder) else { return self.leave_holder(id, now) };
        let holder = match ray.holder {
            Holder::Traversal => flight.unit as usize,
            Holder::ShadowCache => ray.policy_unit as usize,
        };
        if step.entry().is_some() {
            return self.entry(id, holder, now);
        }
        let work = Work::of(step, ray.holder, flight.kind, &self.layout);
        if work.kind != ray.holder.kind() {
            let home = (id as usize).checked_sub(self.dispatch.pool()).unwrap_or(id as usize);
            return self.issue_queues.send(id, holder, self.issue_queues.performer(work.kind, holder, home), now);
        }
        if let Some(end) = self.perform(id, holder, &work.first, Way::Cached, now) {
            self.dispatch.performed(id);
            self.agenda.put(end, id);
        }
    }

    /// The ray's next step accesses an entry, and shadow-cache unit `holder` has the ray.
    fn entry(&mut self, id: u32, holder: usize, now: u64) {
        if self.shadow_cache(id) != holder {
            self.issue_queues.leave(holder, now + 1);
            return self.issue_queues.arrive(id, self.shadow_cache(id), now + 1);
        }
        let unit = holder - self.issue_queues.of_kind(Kind::ShadowCache).start;
        match self.dispatch.access(id, unit, &self.layout) {
            EntryAccess::Taken => self.step(id, now),
            EntryAccess::Performed { sets_modes } => {
                self.rays[id as usize].sets_modes = sets_modes;
                self.access(id, now);
            }
        }
    }

    /// The ray's shadow-cache unit accesses the entry of the next step.
    fn access(&mut self, id: u32, now: u64) {
        let element = self.work_away(id).first;
        let ray = &mut self.rays[id as usize];
        let (unit, sets_modes) = (ray.policy_unit as usize, ray.sets_modes);
        let way = match self.place {
            Place::Triangle => {
                let units = self.issue_queues.of_kind(Kind::Intersection);
                let (line, _) = self.layout.lines(&element);
                let to = units.start + (line.0 % units.len() as u64) as usize;
                return self.issue_queues.send(id, unit, to, now);
            }
            Place::L2 if element.write && !sets_modes => Way::Operand,
            Place::L2 => Way::Past,
            Place::Own | Place::Free => Way::Cached,
        };
        ray.stage = Stage::Entry;
        if let Some(end) = self.perform(id, unit, &element, way, now) {
            self.rays[id as usize].stage = Stage::Step;
            self.dispatch.performed(id);
            self.agenda.put(end, id);
        }
    }

    /// A unit performs an operation for the ray; returns the cycle of its end. `None` if the ray must wait for its
    /// turn; it then acts again.
    #[inline]
    fn perform(&mut self, id: u32, unit: usize, element: &Element, way: Way, at: u64) -> Option<u64> {
        let Self { units, memory, layout, agenda, dispatch, .. } = self;
        let performer = &mut units[unit];
        let waited = performer.stalled.front() == Some(&id);
        if !waited && !performer.stalled.is_empty() && way != Way::Operand {
            performer.stalled.push_back(id);
            return None;
        }
        let ends = (id as usize).checked_sub(dispatch.pool());
        memory.watch.entry(ends.unwrap_or(id as usize), ends.is_some());
        let attributed = dispatch.flights[id as usize].attributed;
        let performed = match way {
            Way::Cached => performer.perform(element, attributed, at, layout, memory),
            Way::Past => performer.perform_past(element, attributed, at, layout, memory),
            Way::Operand => Ok(performer.write_past(element, at, layout, memory)),
        };
        match performed {
            Ok(end) => {
                if waited {
                    performer.stalled.pop_front();
                    performer.stalled.front().iter().for_each(|&&next| agenda.put(at, next));
                }
                Some(end)
            }
            Err(until) => {
                if !waited {
                    performer.stalled.push_back(id);
                }
                agenda.put(until, id);
                None
            }
        }
    }

    /// Units work on the rays that they have taken on.
    fn take_on_all(&mut self) {
        while let Some(Taken { ray, unit, at }) = self.issue_queues.taken() {
            self.take_on(ray, unit, at);
        }
    }

    fn take_on(&mut self, id: u32, unit: usize, at: u64) {
        let ray = &mut self.rays[id as usize];
        ray.away = unit as u32;
        if self.issue_queues.kind(unit) != Kind::ShadowCache {
            return self.first(id, at);
        }
        (ray.holder, ray.policy_unit, ray.stage) = (Holder::ShadowCache, unit as u32, Stage::Step);
        if std::mem::take(&mut ray.undecided) {
            let end = self.units[unit].decide(at);
            self.agenda.put(end, id);
        } else {
            self.step(id, at);
        }
    }

    /// The work of the ray's step away from its holder.
    fn work_away(&self, id: u32) -> Work {
        let (flight, holder) = (&self.dispatch.flights[id as usize], self.rays[id as usize].holder);
        let step = flight.step(holder).expect("a ray that was sent away has a step");
        Work::of(step, holder, flight.kind, &self.layout)
    }

    fn first(&mut self, id: u32, at: u64) {
        let work = self.work_away(id);
        self.rays[id as usize].stage = Stage::First;
        let unit = self.rays[id as usize].away as usize;
        let Some(end) = self.perform(id, unit, &work.first, Way::Cached, at) else { return };
        if work.second.is_some() {
            self.rays[id as usize].stage = Stage::Second;
            self.agenda.put(end, id);
        } else {
            self.go_back(id, &work, end);
        }
    }

    fn second(&mut self, id: u32, at: u64) {
        let work = self.work_away(id);
        let second = work.second.expect("a second operation has something to fetch");
        let unit = self.rays[id as usize].away as usize;
        let Some(end) = self.perform(id, unit, &second, Way::Cached, at) else { return };
        self.go_back(id, &work, end);
    }

    fn go_back(&mut self, id: u32, work: &Work, mut end: u64) {
        let ray = &mut self.rays[id as usize];
        // A test is done then; an entry's operation follows at its owner unit.
        ray.fetched = work.kind == Kind::ShadowCache;
        if !ray.fetched {
            self.dispatch.performed(id);
        }
        if work.divides {
            let (core, a_core) = (self.units[ray.away as usize].core(), self.divisions.len() / self.cores);
            let (open_at, begun) = &mut self.divisions[core * a_core + id as usize % a_core];
            let begin = end.max(*open_at);
            (*open_at, *begun) = (begin + self.division.interval.get(), *begun + 1);
            end = begin + self.division.latency.get();
        }
        ray.stage = Stage::Back;
        self.agenda.put(end + 1, id);
    }

    /// The ray has no more steps at its holder.
    fn leave_holder(&mut self, id: u32, now: u64) {
        let ray = &mut self.rays[id as usize];
        match ray.holder {
            Holder::ShadowCache => {
                let unit = ray.policy_unit as usize;
                self.issue_queues.leave(unit, now + 1);
            }
            Holder::Traversal => {
                self.dispatch.left_slot(id);
                self.dispatch.retire(id, &self.layout);
                if self.dispatch.flights[id as usize].has_policy() {
                    ray.stage = Stage::Policy;
                    return self.agenda.put(now + 1, id);
                }
            }
        }
        if let Some(port) = &mut self.port
            && (id as usize) < self.dispatch.pool()
        {
            let flight = &self.dispatch.flights[id as usize];
            port.take_results(flight.kind, &flight.steps[..flight.path_end], now, &mut self.memory);
            self.dispatch.heed(port);
        }
        self.dispatch.done(id, now);
        self.await_shading();
    }

    fn await_shading(&mut self) {
        if !self.shading
            && let Some(at) = self.dispatch.next_shaded()
        {
            self.shading = true;
            self.agenda.put(at, self.rays.len() as u32);
        }
    }

    /// Hands out all that is possible in cycle `at`, and reads on in the stream.
    fn hand_out(&mut self, at: u64, feed: &mut dyn Feed) -> Result<(), RunError> {
        self.hand_out_all(at, feed)?;
        if feed.marks() {
            let tally = self.tally(at + 1);
            if let Some(warm) = feed.mark(&tally) {
                let l1s = Kind::ALL.into_iter().flat_map(|kind| warm.l1s(kind));
                self.units.iter_mut().zip(l1s).for_each(|(unit, l1)| unit.hold(l1.tags()));
                self.memory.hold(&warm.banks);
            }
        }
        Ok(())
    }

    fn hand_out_all(&mut self, at: u64, feed: &mut dyn Feed) -> Result<(), RunError> {
        while let Some(given) = self.dispatch.next(at, feed, &mut self.layout)? {
            self.tell_frame(at, feed)?;
            let (id, at, holder, stage) = match given {
                Given::Frame(info) => {
                    if let Some(port) = &mut self.port {
                        port.begin_frame(&info, &self.layout, at, &mut self.memory);
                        self.dispatch.heed(port);
                    }
                    let first = self.layout.dynamic_part();
                    self.units.iter_mut().for_each(|unit| unit.drop_from(first, at, &mut self.memory));
                    self.memory.drop_from(first, at);
                    continue;
                }
                Given::Traced(id, at) => (id, at, Holder::Traversal, Stage::Step),
                Given::Skipped(id, at) | Given::Ending(id, at) => (id, at, Holder::ShadowCache, Stage::Policy),
            };
            if let Some(port) = &mut self.port
                && !matches!(given, Given::Ending(..))
            {
                port.hand_over(self.dispatch.handed_over_at(), &mut self.memory);
                self.dispatch.heed(port);
            }
            let undecided = matches!(given, Given::Skipped(..)) && self.dispatch.units_decide();
            self.rays[id as usize] = Whereabouts { stage, holder, undecided, ..Whereabouts::IDLE };
            self.agenda.put(at, id);
        }
        self.tell_frame(at, feed)
    }

    /// Reports the counts up to cycle `at` if a frame is over.
    fn tell_frame(&mut self, at: u64, feed: &mut dyn Feed) -> Result<(), RunError> {
        if feed.wants_frame() {
            self.frames_over = [self.frames_over[1], at + 1];
            feed.frame_counted(&self.tally(at + 1))?;
        }
        Ok(())
    }

    /// The receiver of accesses.
    pub(crate) fn into_watch(self) -> W {
        self.memory.watch
    }

    /// Lets all pending work end; returns the cycle of its end.
    fn settle(&mut self, now: u64) -> u64 {
        let units = self.units.iter().map(Unit::settled_at).max().unwrap_or(0);
        self.units.iter_mut().for_each(|unit| unit.settle(u64::MAX, &mut self.memory));
        let host = self.port.as_ref().map_or(0, Port::lets_end_at);
        let end = now.max(units).max(host).max(self.memory.settled_at());
        self.memory.settle(u64::MAX);
        end.max(self.memory.settled_at())
    }
}

impl<W: Watch> Engine for Profile<W> {
    fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError> {
        let shading_ends = self.rays.len() as u32;
        let mut last = 0;
        self.hand_out(0, feed)?;
        while let Some(now) = self.agenda.turn() {
            while let Some(id) = self.agenda.take() {
                if id == shading_ends {
                    self.shading = false;
                    self.dispatch.shaded(now);
                    self.await_shading();
                } else {
                    self.act(id, now);
                }
            }
            last = now;
            if std::mem::take(&mut self.dispatch.freed) {
                self.hand_out(now + 1, feed)?;
            }
        }
        if !self.dispatch.is_over() {
            let queues = format!("rays in flight {}", self.dispatch.in_flight());
            return Err(RunError::Deadlock { cycle: last, queues });
        }
        Ok((self.settle(last) + 1).max(self.frames_over[0]))
    }

    fn tally(&self, cycles: u64) -> Tally {
        let units = |kind| self.units[self.issue_queues.of_kind(kind)].iter().map(Unit::tally).collect();
        Tally {
            cycles,
            rays: self.dispatch.rays_done,
            dispatcher: busy(self.dispatch.busy),
            units: Kind::ALL.map(units),
            divisions: self.divisions.iter().map(|&(_, begun)| busy(begun * self.division.interval.get())).collect(),
            banks: self.memory.banks(),
            port: self.port.as_ref().map(|port| port.counts.clone()).unwrap_or_default(),
            channels: self.memory.channels(cycles),
            ..Tally::default()
        }
    }

    fn logs(&mut self) -> Vec<&mut ChannelLog> {
        Vec::new()
    }
}
