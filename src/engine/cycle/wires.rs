//! All links between the parts, and the state that all parts share.

use super::gathering::Gathering;
use super::link::Link;
use super::port::Port;
use super::ray::{Id, Origin, Ray, Sender};
use super::request::{DramRequest, Request};
use super::words::Words;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::quantity::LineAddr;
use crate::stats::TrafficClass;
use crate::stream::{Header, RayKind, Step, Totals};

fn put_if_room(queue: &mut Link<Id>, now: u64, id: Id) -> bool {
    let room = queue.has_room();
    if room {
        queue.put(now, id);
    }
    room
}

/// Links and shared state.
pub(super) struct Wires {
    cores: usize,
    pool: usize,
    /// The rays in the machine, by pool entry.
    pub rays: Vec<Option<Ray>>,
    pub layout: Layout,
    pub words: Words,
    gathering: Gathering,
    /// Replayed work of the current frame.
    pub replayed: Totals,
    /// From the dispatcher to each traversal unit.
    pub dispatched: Vec<Link<Id>>,
    /// To each list, intersection and division unit.
    pub lists: Vec<Link<Id>>,
    pub tests: Vec<Link<Id>>,
    pub divisions: Vec<Link<Id>>,
    /// From other units back to each traversal, list and shadow-cache unit.
    pub back_in_traversal: Vec<Link<Id>>,
    pub back_in_list: Vec<Link<Id>>,
    pub back_in_policy: Vec<Link<Id>>,
    /// To each list and intersection unit: a ray that was elsewhere has released its context.
    pub list_left: Vec<Link<()>>,
    pub test_left: Vec<Link<()>>,
    /// To each shadow-cache unit: retired and skipped rays, and rays from other shadow-cache units.
    pub retired: Vec<Link<Id>>,
    /// To each shadow-cache unit: its steps of the end-of-frame update.
    pub frame_end: Vec<Link<Vec<Step>>>,
    /// From the host to the dispatcher; and completed rays to the host.
    pub in_fifo: Link<Origin>,
    pub out_fifo: Link<Id>,
    /// To the dispatcher: traversal units in which a slot was freed.
    pub freed_slots: Link<usize>,
    /// To the dispatcher: the frame is over.
    pub frame_over: Link<()>,
    /// From L1s to each L2 bank, ordered by core.
    pub to_bank: Vec<Link<Request>>,
    /// The core of each L1.
    core_of_l1: Vec<usize>,
    /// The banks of each class's cache: the first and their number.
    homes: [(usize, u64); TrafficClass::ALL.len()],
    /// From the L2 to each L1: traversal units', list units', intersection units', shadow-cache units'.
    pub to_l1: Vec<Link<LineAddr>>,
    /// The host's port to the DRAM.
    pub port: Option<Port>,
    /// From banks and the port to each channel of the DRAM.
    pub to_channel: Vec<Link<DramRequest>>,
    /// From the DRAM to each bank.
    pub from_dram: Vec<Link<LineAddr>>,
}

impl Wires {
    pub(super) fn new(spec: &MachineSpec, header: &Header) -> Self {
        fn links<T>(count: usize, link: impl Fn() -> Link<T>) -> Vec<Link<T>> {
            (0..count).map(|_| link()).collect()
        }
        let (cores, pool) = (spec.cores.size(), spec.pool() as usize);
        let units = cores * spec.traversal.count.size();
        let lists = cores * spec.list.count.size();
        let tests = cores * spec.intersection.count.size();
        let divisions = cores * spec.division.count.size();
        let policies = cores * spec.shadow_cache.count.size();
        let entries = pool + policies * spec.shadow_cache.contexts.size();
        let kinds = [units, lists, tests, policies];
        let core_of_l1 = kinds.into_iter().flat_map(|count| (0..count).map(move |unit| unit * cores / count)).collect();
        let caches = spec.l2.caches();
        let a_core = caches.iter().map(|(_, cache)| (cache.banks.size(), cache.queue.size()));
        let queues = (0..cores).flat_map(|_| a_core.clone());
        let to_bank = queues.flat_map(|(banks, places)| links(banks, || Link::new(places, 1))).collect();
        Self {
            cores,
            pool,
            rays: (0..entries).map(|_| None).collect(),
            layout: Layout::new(header, spec),
            words: Words::new(&spec.shadow_cache, policies, header),
            gathering: Gathering::new(cores * spec.shadow_cache.gather.size()),
            replayed: Totals::default(),
            dispatched: links(units, || Link::new(usize::MAX, spec.dispatcher.latency.get())),
            lists: links(lists, || Link::new(spec.list.queue.size(), 1)),
            tests: links(tests, || Link::new(spec.intersection.queue.size(), 1)),
            divisions: links(divisions, || Link::new(spec.division.queue.size(), 1)),
            back_in_traversal: links(units, Link::unbounded),
            back_in_list: links(lists, Link::unbounded),
            back_in_policy: links(policies, Link::unbounded),
            list_left: links(lists, Link::unbounded),
            test_left: links(tests, Link::unbounded),
            retired: links(policies, || Link::new(pool, 1)),
            frame_end: links(policies, Link::unbounded),
            in_fifo: Link::new(cores * spec.dispatcher.in_fifo.size(), 1),
            out_fifo: Link::new(cores * spec.dispatcher.out_fifo.size(), 1),
            freed_slots: Link::unbounded(),
            frame_over: Link::unbounded(),
            to_bank,
            core_of_l1,
            homes: TrafficClass::ALL.map(|class| {
                let before = &caches[..spec.l2.home(class)];
                let first = before.iter().map(|(_, cache)| cache.banks.size()).sum();
                (first, caches[spec.l2.home(class)].1.banks.get())
            }),
            to_l1: links(kinds.into_iter().sum(), Link::unbounded),
            port: Port::new(spec, cores * spec.l2.banks() as usize),
            to_channel: links(spec.dram.channels.size(), || Link::new(spec.dram.queue.size(), 1)),
            from_dram: links(cores * spec.l2.banks() as usize, Link::unbounded),
        }
    }

    /// The cycle ends.
    pub(super) fn settle(&mut self) {
        fn all<T>(links: &mut [Link<T>]) {
            links.iter_mut().for_each(Link::settle);
        }
        all(&mut self.dispatched);
        all(&mut self.lists);
        all(&mut self.tests);
        all(&mut self.divisions);
        all(&mut self.back_in_traversal);
        all(&mut self.back_in_list);
        all(&mut self.back_in_policy);
        all(&mut self.list_left);
        all(&mut self.test_left);
        all(&mut self.to_bank);
        all(&mut self.to_l1);
        all(&mut self.to_channel);
        all(&mut self.from_dram);
        all(&mut self.retired);
        all(&mut self.frame_end);
        self.in_fifo.settle();
        self.out_fifo.settle();
        self.freed_slots.settle();
        self.frame_over.settle();
    }

    /// Whether the host's port lets a ray be handed over.
    pub(super) fn port_lets_in(&self, now: u64) -> bool {
        self.port.as_ref().is_none_or(|port| port.lets_in(now))
    }

    /// Whether the host's port lets the end-of-frame update begin.
    pub(super) fn port_lets_end(&self, now: u64) -> bool {
        self.port.as_ref().is_none_or(|port| port.lets_end(now))
    }

    /// Cycle `now` of the host's port.
    pub(super) fn tick_port(&mut self, now: u64) {
        let Self { port, to_channel, .. } = self;
        if let Some(port) = port {
            port.tick(now, to_channel);
        }
    }

    /// The ray in entry `id`.
    pub(super) fn ray(&mut self, id: Id) -> &mut Ray {
        self.rays[id].as_mut().expect("an entry that is under way holds a ray")
    }

    /// The core of the unit that holds a slot or a context for the ray.
    fn core_of(&mut self, id: Id) -> usize {
        match self.ray(id).sender {
            Sender::Traversal(unit) => unit * self.cores / self.dispatched.len(),
            Sender::ShadowCache(unit) => unit * self.cores / self.retired.len(),
        }
    }

    /// The unit for a ray, among `units` units of a kind: in the ray's core, by the number of its entry.
    fn unit_of(&mut self, id: Id, units: usize) -> usize {
        let number = if id < self.pool { id } else { id - self.pool };
        let a_core = units / self.cores;
        self.core_of(id) * a_core + number % a_core
    }

    /// The intersection unit that tests for the ray.
    pub(super) fn test_unit(&mut self, id: Id) -> usize {
        self.unit_of(id, self.tests.len())
    }

    /// Sends a ray to its list unit, if that has a place in its queue.
    pub(super) fn send_to_list(&mut self, now: u64, id: Id) -> bool {
        let unit = self.unit_of(id, self.lists.len());
        put_if_room(&mut self.lists[unit], now, id)
    }

    /// Sends a ray to its intersection unit, if that has a place in its queue.
    pub(super) fn send_to_test(&mut self, now: u64, id: Id) -> bool {
        let unit = self.test_unit(id);
        put_if_room(&mut self.tests[unit], now, id)
    }

    /// Sends a ray to the intersection unit that accesses `line`, if that has a place in its queue.
    pub(super) fn send_to_access(&mut self, now: u64, id: Id, line: LineAddr) -> bool {
        let unit = line.0 as usize % self.tests.len();
        put_if_room(&mut self.tests[unit], now, id)
    }

    /// Sends a ray to its division unit, if that has a place in its queue.
    pub(super) fn send_to_division(&mut self, now: u64, id: Id) -> bool {
        let unit = self.unit_of(id, self.divisions.len());
        put_if_room(&mut self.divisions[unit], now, id)
    }

    /// A ray's work at an intersection unit is done: a test, or an access to an entry.
    pub(super) fn test_is_over(&mut self, now: u64, id: Id) {
        let ray = self.rays[id].as_mut().expect("an entry that is under way holds a ray");
        let tested = matches!(ray.tested_step().front(), Some(Step::Triangle { .. }));
        if !tested {
            // Only the access was made here; the operation follows at the shadow-cache unit.
            ray.accessed = true;
            return self.give_back(now, id);
        }
        ray.tested_step().pop_front();
        let counted = match (ray.sender, ray.kind) {
            (Sender::ShadowCache(_), _) => &mut self.replayed.policy_triangle_tests,
            (Sender::Traversal(_), RayKind::Shadow) => &mut self.replayed.shadow_triangle_tests,
            (Sender::Traversal(_), _) => &mut self.replayed.triangle_tests,
        };
        *counted += 1;
        let Some(list) = ray.list else { return self.give_back(now, id) };
        if matches!(ray.path.front(), Some(Step::List(_) | Step::Triangle { .. })) {
            self.back_in_list[list].put(now, id);
        } else {
            ray.list = None;
            self.list_left[list].put(now, ());
            self.give_back(now, id);
        }
    }

    /// The ray has ended its path.
    pub(super) fn path_done(&mut self, id: Id) {
        let ray = self.rays[id].as_mut().expect("an entry that is under way holds a ray");
        self.words.work.gathered_writes += self.gathering.path_done(ray, &self.layout);
    }

    /// Sends a completed ray to the out FIFO, if that has a place.
    pub(super) fn send_out(&mut self, now: u64, id: Id) -> bool {
        let room = self.out_fifo.has_room();
        if room {
            self.out_fifo.put(now, id);
            self.ray(id).done = now;
        }
        room
    }

    /// Sends a ray back to the traversal or shadow-cache unit that holds a place for it.
    pub(super) fn give_back(&mut self, now: u64, id: Id) {
        match self.ray(id).sender {
            Sender::Traversal(unit) => self.back_in_traversal[unit].put(now, id),
            Sender::ShadowCache(unit) => self.back_in_policy[unit].put(now, id),
        }
    }

    /// Sends a ray to its first shadow-cache unit: the owner of its first entry, or the unit by the ray's number.
    pub(super) fn send_to_policy(&mut self, now: u64, id: Id) {
        let ray = self.rays[id].as_ref().expect("an entry that is under way holds a ray");
        let first = if ray.undecided { None } else { ray.policy.front() };
        let home = first.and_then(|&step| self.words.home(step, &self.layout));
        let unit = home.unwrap_or(id % self.retired.len());
        self.retired[unit].put(now, id);
    }

    /// Begins an end-of-frame update with these steps.
    pub(super) fn begin_end(&mut self, now: u64, steps: Vec<Step>) {
        let (steps, free) = self.words.without_free(steps);
        self.replayed.count_policy(free.into_iter());
        if steps.is_empty() && !self.words.registers_are_there() {
            self.frame_over.put(now, ());
            return;
        }
        self.words.ending = self.frame_end.len();
        let home = |step| self.words.home(step, &self.layout).unwrap_or(0);
        for (unit, link) in self.frame_end.iter_mut().enumerate() {
            link.put(now, steps.iter().copied().filter(|&step| home(step) == unit).collect());
        }
    }

    /// The queue of the bank for `request` of an L1.
    pub(super) fn bank_of(&mut self, request: &Request) -> &mut Link<Request> {
        let (first, banks) = self.homes[request.class as usize];
        let before = self.core_of_l1[request.from] * (self.to_bank.len() / self.cores);
        &mut self.to_bank[before + first + (request.line.0 % banks) as usize]
    }

    /// Whether no request or line is between L1s, L2 and DRAM.
    pub(super) fn memory_is_empty(&self) -> bool {
        self.to_bank.iter().all(Link::is_empty)
            && self.to_l1.iter().all(Link::is_empty)
            && self.to_channel.iter().all(Link::is_empty)
            && self.from_dram.iter().all(Link::is_empty)
    }
}
