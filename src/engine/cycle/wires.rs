//! All links between the parts, and what all parts can see.

use super::link::Link;
use super::ray::{Id, Ray};
use super::words::Words;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::memory::dram::mapping::Place;
use crate::quantity::{Bytes, LineAddr};
use crate::stats::TrafficClass;
use crate::stream::{Header, Step, Totals};

/// What a cache asks of the level below.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    pub line: LineAddr,
    pub class: TrafficClass,
    pub write: bool,
    pub bytes: Bytes,
    /// The L1, or the bank of the L2, that asks.
    pub from: usize,
}

/// A request in a channel of the DRAM.
#[derive(Clone, Copy, Debug)]
pub struct DramRequest {
    pub request: Request,
    pub place: Place,
    pub activated: bool,
    pub precharged: bool,
    pub bursts_done: u64,
}

/// Links and common knowledge.
pub struct Wires {
    /// The rays in the machine, by their entries.
    pub rays: Vec<Option<Ray>>,
    pub layout: Layout,
    pub words: Words,
    /// What was replayed of the frame so far.
    pub replayed: Totals,
    /// From the dispatcher to each traversal unit.
    pub dispatched: Vec<Link<Id>>,
    /// To each intersection unit.
    pub tests: Vec<Link<Id>>,
    /// From intersection units to each traversal unit.
    pub tested: Vec<Link<Id>>,
    /// From intersection units to each shadow-cache unit.
    pub tested_for_policy: Vec<Link<Id>>,
    /// Retired and skipped rays, and those of other such units, to each shadow-cache unit.
    pub retired: Vec<Link<Id>>,
    /// A frame's end and its steps to each shadow-cache unit.
    pub frame_end: Vec<Link<Vec<Step>>>,
    /// To the dispatcher: rays that are done.
    pub done: Link<Id>,
    /// To the dispatcher: units in which a slot was freed.
    pub freed_slots: Link<usize>,
    /// To the dispatcher: the frame is over.
    pub frame_over: Link<()>,
    /// From L1s to each bank of the L2.
    pub to_bank: Vec<Link<Request>>,
    /// The banks that are the home of each class: the first, and how many.
    homes: [(usize, u64); TrafficClass::ALL.len()],
    /// From the L2 to each L1: traversal units', intersection units', shadow-cache units'.
    pub to_l1: Vec<Link<LineAddr>>,
    /// From banks to each channel of the DRAM.
    pub to_channel: Vec<Link<DramRequest>>,
    /// From the DRAM to each bank.
    pub from_dram: Vec<Link<LineAddr>>,
}

impl Wires {
    pub fn new(spec: &MachineSpec, header: &Header) -> Self {
        fn links<T>(count: usize, link: impl Fn() -> Link<T>) -> Vec<Link<T>> {
            (0..count).map(|_| link()).collect()
        }
        let units = spec.traversal.count.size();
        let tests = spec.intersection.count.size();
        let policies = spec.shadow_cache.count.size();
        let entries = spec.dispatcher.rays.size() + policies * spec.shadow_cache.contexts.size();
        let caches = spec.l2.caches();
        let queues = caches.iter().map(|(_, cache)| (cache.banks.size(), cache.queue.size()));
        let to_bank = queues.flat_map(|(banks, places)| links(banks, || Link::new(places, 1))).collect();
        Self {
            rays: (0..entries).map(|_| None).collect(),
            layout: Layout::new(header, spec),
            words: Words::new(&spec.shadow_cache, header),
            replayed: Totals::default(),
            dispatched: links(units, || Link::new(usize::MAX, spec.dispatcher.latency.get())),
            tests: links(tests, || Link::new(spec.intersection.queue.size(), 1)),
            tested: links(units, Link::unbounded),
            tested_for_policy: links(policies, Link::unbounded),
            retired: links(policies, || Link::new(spec.dispatcher.rays.size(), 1)),
            frame_end: links(policies, Link::unbounded),
            done: Link::unbounded(),
            freed_slots: Link::unbounded(),
            frame_over: Link::unbounded(),
            to_bank,
            homes: TrafficClass::ALL.map(|class| {
                let before = &caches[..spec.l2.home(class)];
                let first = before.iter().map(|(_, cache)| cache.banks.size()).sum();
                (first, caches[spec.l2.home(class)].1.banks.get())
            }),
            to_l1: links(units + tests + policies, Link::unbounded),
            to_channel: links(spec.dram.channels.size(), || Link::new(spec.dram.queue.size(), 1)),
            from_dram: links(spec.l2.banks() as usize, Link::unbounded),
        }
    }

    /// The cycle ends.
    pub fn settle(&mut self) {
        fn all<T>(links: &mut [Link<T>]) {
            links.iter_mut().for_each(Link::settle);
        }
        all(&mut self.dispatched);
        all(&mut self.tests);
        all(&mut self.tested);
        all(&mut self.to_bank);
        all(&mut self.to_l1);
        all(&mut self.to_channel);
        all(&mut self.from_dram);
        all(&mut self.tested_for_policy);
        all(&mut self.retired);
        all(&mut self.frame_end);
        self.done.settle();
        self.freed_slots.settle();
        self.frame_over.settle();
    }

    /// The ray in entry `id`.
    pub fn ray(&mut self, id: Id) -> &mut Ray {
        self.rays[id].as_mut().expect("an entry that is under way holds a ray")
    }

    /// Sends a ray to the intersection unit that `number` chooses, if that has a place in its queue.
    pub fn send_to_test(&mut self, now: u64, id: Id, number: u64) -> bool {
        let unit = (number % self.tests.len() as u64) as usize;
        let room = self.tests[unit].has_room();
        if room {
            self.tests[unit].put(now, id);
        }
        room
    }

    /// Sends a ray to the shadow-cache unit where it begins.
    pub fn send_to_policy(&mut self, now: u64, id: Id) {
        let ray = self.rays[id].as_ref().expect("an entry that is under way holds a ray");
        let first = if ray.undecided { None } else { ray.policy.front() };
        let home = first.and_then(|&step| self.words.home(step, &self.layout));
        let unit = home.unwrap_or(id % self.retired.len());
        self.retired[unit].put(now, id);
    }

    /// A frame's end of these steps begins.
    pub fn begin_end(&mut self, now: u64, steps: Vec<Step>) {
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

    /// The queue of the bank that `request` of an L1 goes to.
    pub fn bank_of(&mut self, request: &Request) -> &mut Link<Request> {
        let (first, banks) = self.homes[request.class as usize];
        &mut self.to_bank[first + (request.line.0 % banks) as usize]
    }

    /// Whether nothing is between L1s, L2 and DRAM.
    pub fn memory_is_empty(&self) -> bool {
        self.to_bank.iter().all(Link::is_empty)
            && self.to_l1.iter().all(Link::is_empty)
            && self.to_channel.iter().all(Link::is_empty)
            && self.from_dram.iter().all(Link::is_empty)
    }
}
