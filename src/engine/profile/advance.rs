//! How a ray advances: its holder performs its steps, or sends it to other units.

use super::engine::Profile;
use super::entries::EntryAccess;
use super::issue_queues::Taken;
use super::watch::Watch;
use super::whereabouts::{Stage, Way};
use crate::engine::work::{Holder, Work};
use crate::machine::kinds::Kind;
use crate::machine::layout::Element;
use crate::machine::shadow_cache::Place;
use crate::stream::Step;

impl<W: Watch> Profile<W> {
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
    pub(super) fn act(&mut self, id: u32, now: u64) {
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
            Place::L2 => Way::Bypass,
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
            Way::Bypass => performer.perform_bypass(element, attributed, at, layout, memory),
            Way::Operand => Ok(performer.write_bypass(element, at, layout, memory)),
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
            end = self.divisions[core * a_core + id as usize % a_core].divide(&self.division, end);
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
}
