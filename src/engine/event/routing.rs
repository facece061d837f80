//! Which unit a ray goes to next, and how it gets there.

use super::links::Links;
use super::ray::{FREES_LIST, GONE, Owner, RayId};
use crate::machine::parts::Parts;
use crate::memory::queue::Queue;
use crate::memory::{PartId, Wake};
use crate::stream::{RayKind, Step, Store};

impl Links {
    /// Sends a ray of a core to its list unit. Returns false if there is no place; `from` is then woken when there is
    /// one.
    pub(crate) fn send_to_list(&mut self, ray: RayId, core: u32, from: PartId, now: u64) -> bool {
        let unit = self.parts.choose(self.parts.list, core, ray.into());
        send(&mut self.lists[unit as usize], ray, (from, self.parts.list(unit)), now, &mut self.clock)
    }

    /// As [`Links::send_to_list`], for the ray's intersection unit.
    pub(crate) fn send_to_test(&mut self, ray: RayId, core: u32, from: PartId, now: u64) -> bool {
        let pool = self.rays.len() - self.parts.shadow_cache as usize * self.shadow_cache.contexts.size();
        let number = ray as u64 - if ray as usize >= pool { pool as u64 } else { 0 };
        self.send_to_unit(ray, self.parts.intersection_of(core, number), from, now)
    }

    /// As [`Links::send_to_list`], for the intersection unit whose L1 serves the line of the ray's entry.
    pub(crate) fn send_to_access(&mut self, ray: RayId, from: PartId, now: u64) -> bool {
        let (line, _) = self.layout.lines(&self.entry_element(ray));
        self.send_to_unit(ray, (line.0 % u64::from(self.parts.intersection)) as u32, from, now)
    }

    fn send_to_unit(&mut self, ray: RayId, unit: u32, from: PartId, now: u64) -> bool {
        send(&mut self.tests[unit as usize], ray, (from, self.parts.intersection(unit)), now, &mut self.clock)
    }

    /// As [`Links::send_to_list`], for the ray's division unit.
    pub(crate) fn send_to_division(&mut self, ray: RayId, core: u32, from: PartId, now: u64) -> bool {
        let unit = self.parts.choose(self.parts.division, core, ray.into());
        send(&mut self.divisions[unit as usize], ray, (from, self.parts.division(unit)), now, &mut self.clock)
    }

    /// An intersection or division unit is done with a ray: its test, or the access to its entry. The ray goes back to
    /// its list unit or to the shadow-cache unit that sent it.
    pub(crate) fn tested(&mut self, id: RayId, now: u64) {
        let fetched = self.rays[id as usize].step().is_some_and(|step| step.entry().is_some());
        self.rays[id as usize].fetched = fetched;
        if !fetched {
            self.count_test(id);
        }
        let ray = &self.rays[id as usize];
        match (ray.list, ray.owner) {
            (Some(unit), _) => {
                self.listed[unit as usize].push_back((now + 1, id));
                self.clock.wake(self.parts.list(unit), now + 1);
            }
            (None, Owner::ShadowCache(unit)) => {
                self.back_in_policy[unit as usize].push_back((now + 1, id));
                self.clock.wake(self.parts.shadow_cache(unit), now + 1);
            }
            (None, Owner::Traversal(_)) => unreachable!("`tested_ahead` has sent the ray back"),
        }
    }

    /// If the triangle test that ends in cycle `ends` sends the ray back to a traversal unit, sends it ahead of time.
    /// Returns the number to keep in the unit's pipeline, with the flags [`GONE`] and [`FREES_LIST`] if they apply.
    pub(crate) fn tested_ahead(&mut self, id: RayId, from: PartId, ends: u64) -> RayId {
        let Owner::Traversal(unit) = self.rays[id as usize].owner else { return id };
        let ray = &self.rays[id as usize];
        if ray.list.is_some() && ray.stays_in_list() {
            return id;
        }
        self.count_test(id);
        let listed = self.rays[id as usize].list.take().is_some();
        self.send_back(id, unit, from, ends);
        id | GONE | if listed { FREES_LIST } else { 0 }
    }

    /// The operation of a ray that [`Links::tested_ahead`] has sent back ends in cycle `now`: frees its list context.
    pub(crate) fn left(&mut self, id: RayId, core: u32, now: u64) {
        if id & FREES_LIST != 0 {
            let unit = self.parts.choose(self.parts.list, core, (id & !(GONE | FREES_LIST)).into());
            self.free_list(unit, now);
        }
    }

    fn free_list(&mut self, unit: u32, now: u64) {
        self.freed_lists[unit as usize] += 1;
        self.clock.wake(self.parts.list(unit), now + 1);
    }

    fn count_test(&mut self, id: RayId) {
        let ray = &mut self.rays[id as usize];
        ray.steps.advance();
        match (ray.owner, ray.kind) {
            (Owner::ShadowCache(_), _) => self.replayed.policy_triangle_tests += 1,
            (Owner::Traversal(_), RayKind::Shadow) => self.replayed.shadow_triangle_tests += 1,
            (Owner::Traversal(_), _) => self.replayed.triangle_tests += 1,
        }
    }

    /// Sends a ray that is done to the out FIFO. Returns false as [`Links::send_to_list`] does.
    pub(crate) fn send_out(&mut self, ray: RayId, from: PartId, now: u64) -> bool {
        let sent = send(&mut self.done, ray, (from, Parts::DISPATCHER), now, &mut self.clock);
        if sent {
            self.rays[ray as usize].done = now;
        }
        sent
    }

    /// Sends a ray to its first shadow-cache unit: the owner unit of its next step's entry, or, for a decision or
    /// another step, one chosen by the ray's number.
    pub(crate) fn send_to_shadow_cache(&mut self, id: RayId, now: u64) {
        let ray = &self.rays[id as usize];
        let entry = ray.step().filter(|_| !ray.undecided).and_then(Step::entry);
        let unit = match entry {
            Some((store, index)) => self.home(store, index),
            None => id % self.parts.shadow_cache,
        };
        self.pass_on(id, unit, now);
    }

    /// Sends a ray to a shadow-cache unit.
    pub(crate) fn pass_on(&mut self, ray: RayId, unit: u32, now: u64) {
        self.retired[unit as usize].push_back((now + 1, ray));
        self.clock.wake(self.parts.shadow_cache(unit), now + 1);
    }

    /// The owner unit of an entry.
    pub(crate) fn home(&self, store: Store, index: u32) -> u32 {
        (self.layout.line_of(store, index).0 % u64::from(self.parts.shadow_cache)) as u32
    }
}

/// Puts `ray` into a unit's queue. Returns false if there is no place; the sender is then woken when there is one.
fn send(queue: &mut Queue<RayId>, ray: RayId, (from, to): (PartId, PartId), now: u64, clock: &mut impl Wake) -> bool {
    if !queue.has_room(now) {
        queue.wait_for_room(from, now, clock);
        return false;
    }
    queue.put(ray, now + 1);
    clock.wake(to, now + 1);
    true
}
