//! What lies between the parts of the machine: rays in flight, queues between units, the shared memory, and the alarm
//! clock that wakes parts.

use super::memory::Memory;
use super::port::Port;
use super::ray::{Fetch, Ray, RayId};
use super::wheel::Wheel;
use crate::engine::gathering::{Gathering, HitId, Retiring};
use crate::engine::source::{StoreWork, StreamFault, check_step};
use crate::engine::store_steps::StoreSteps;
use crate::machine::MachineSpec;
use crate::machine::layout::{Element, Layout};
use crate::machine::parts::Parts;
use crate::machine::shadow_cache::{Place, ShadowCacheSpec};
use crate::memory::dram::Dram;
use crate::memory::l2::L2;
use crate::memory::queue::Queue;
use crate::memory::ring::Ring;
use crate::memory::{PartId, Wake};
use crate::quantity::{LineAddr, NodeId};
use crate::stream::{Chunk, FrameInfo, Header, Step, Totals};

/// A queue with a place for everything that can come.
pub(super) type Inbox<T> = Ring<(u64, T)>;

/// Takes the first of `inbox` if it is there in cycle `now`.
#[inline]
pub(super) fn take<T: Copy>(inbox: &mut Inbox<T>, now: u64) -> Option<T> {
    let &(at, entry) = inbox.front()?;
    if at > now {
        return None;
    }
    inbox.drop_front();
    Some(entry)
}

/// A ray that comes back to its traversal unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Back {
    /// The cycle from which on it is there.
    pub at: u64,
    /// Which unit sends it: its place in turn in the cycle before. Rays of a cycle come in this order.
    turn: u32,
    /// The ray.
    pub ray: RayId,
}

/// A line from the L2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    /// The cycle from which on it is there.
    pub at: u64,
    /// Which bank sends it: its place in turn in the cycle before. Answers of a cycle come in this order.
    turn: u32,
    /// The line.
    pub line: LineAddr,
}

/// What the parts share.
#[derive(Clone, Debug)]
pub(crate) struct Links {
    /// The parts' numbers.
    pub parts: Parts,
    /// The pool's rays, then the steps of a frame's end.
    pub rays: Vec<Ray>,
    /// Addresses.
    pub layout: Layout,
    /// Rays from the dispatcher to each traversal unit.
    pub dispatched: Vec<Inbox<RayId>>,
    /// Rays from list, intersection and division units back to each traversal unit, known since their last operations
    /// there began.
    pub returned: Vec<Ring<Back>>,
    /// What comes to a traversal unit and is not known in a cycle comes more than so many cycles later.
    horizon: u64,
    /// The next cycle that somebody looks at.
    pub looked_at: u64,
    /// The next cycle in which each traversal unit acts for sure.
    pub wakes: Vec<u64>,
    /// Rays to each list unit.
    pub lists: Vec<Queue<RayId>>,
    /// Rays from intersection and division units back to each list unit.
    pub listed: Vec<Inbox<RayId>>,
    /// Contexts of each list unit that others freed.
    pub freed_lists: Vec<usize>,
    /// Rays to each intersection unit.
    pub tests: Vec<Queue<RayId>>,
    /// Contexts of each intersection unit that division units freed.
    pub freed_tests: Vec<usize>,
    /// Rays to each division unit.
    pub divisions: Vec<Queue<RayId>>,
    /// Rays back from intersection units to each shadow-cache unit.
    pub back_in_policy: Vec<Inbox<RayId>>,
    /// Retired and skipped rays, and those of other units, to each shadow-cache unit.
    pub retired: Vec<Inbox<RayId>>,
    /// The out FIFO: rays that are done, to the host.
    pub done: Queue<RayId>,
    /// Traversal units in which a slot was freed, to the dispatcher.
    pub freed: Vec<u32>,
    /// The frame's end, to each shadow-cache unit: from when on, and its steps.
    pub frame_end: Vec<Option<(u64, Vec<Step>)>>,
    /// Units whose part of the frame's end is not done.
    pub units_at_the_end: u32,
    /// Whether the frame's end is done, to the dispatcher.
    pub frame_over: bool,
    /// Which steps of the policy's stores are performed.
    store_steps: StoreSteps,
    /// The shortest latency of what comes to a traversal unit, and that of a list unit.
    latencies: (u64, u64),
    /// What was done with stores otherwise than recorded.
    pub stores: StoreWork,
    /// Hits whose updates are gathered.
    pub gathering: Gathering,
    /// The shadow-cache units' spec.
    pub shadow_cache: ShadowCacheSpec,
    /// Lines from the L2, to the L1 of each part: those that a bank has, with the cycles in which their latency is
    /// over.
    pub lines: Vec<Ring<Answer>>,
    /// The L2.
    pub l2: L2,
    /// The host's port to the DRAM.
    pub port: Option<Port>,
    /// The DRAM.
    pub dram: Dram,
    /// What was replayed of the frame so far.
    pub replayed: Totals,
    /// Wakes parts.
    pub clock: Wheel,
}

impl Links {
    /// Empty links of a machine that replays a stream.
    pub(crate) fn new(spec: &MachineSpec, header: &Header, clock: Wheel) -> Self {
        let parts = Parts::new(spec);
        let line = spec.line_bytes.get();
        let contexts = parts.shadow_cache as usize * spec.shadow_cache.contexts.size();
        let entries = spec.pool() as usize + contexts;
        let (tests, divisions) = (spec.intersection.latency.get(), spec.division.latency.get());
        let answers = Memory::new(spec).answer_latency;
        let shortest = tests.min(divisions).min(answers).min(spec.dispatcher.latency.get());
        Self {
            parts,
            rays: vec![Ray::default(); entries],
            layout: Layout::new(header, spec),
            dispatched: vec![Inbox::new(); parts.traversal as usize],
            returned: vec![Ring::new(); parts.traversal as usize],
            horizon: 0,
            looked_at: u64::MAX,
            wakes: vec![u64::MAX; parts.traversal as usize],
            lists: vec![Queue::new(spec.list.queue.size()); parts.list as usize],
            listed: vec![Inbox::new(); parts.list as usize],
            freed_lists: vec![0; parts.list as usize],
            tests: vec![Queue::new(spec.intersection.queue.size()); parts.intersection as usize],
            freed_tests: vec![0; parts.intersection as usize],
            divisions: vec![Queue::new(spec.division.queue.size()); parts.division as usize],
            back_in_policy: vec![Inbox::new(); parts.shadow_cache as usize],
            retired: vec![Inbox::new(); parts.shadow_cache as usize],
            done: Queue::new(parts.cores as usize * spec.dispatcher.out_fifo.size()),
            freed: Vec::new(),
            frame_end: vec![None; parts.shadow_cache as usize],
            units_at_the_end: 0,
            frame_over: false,
            latencies: (shortest, spec.list.latency.get()),
            store_steps: StoreSteps::new(&spec.shadow_cache, header),
            stores: StoreWork::default(),
            gathering: Gathering::new(spec.cores.size() * spec.shadow_cache.gather.size()),
            shadow_cache: spec.shadow_cache,
            lines: vec![Ring::new(); parts.count()],
            l2: spec.l2.build(parts.bank(0), parts.cores, line),
            port: Port::new(spec, &parts),
            dram: Dram::new(&spec.dram, spec.clock_mhz.get(), line, parts.channel(0)),
            replayed: Totals::default(),
            clock,
        }
    }

    /// Takes the steps of the policy that are not performed out of a ray that is handed over, and counts them.
    pub(crate) fn leave_out(&mut self, ray: RayId) {
        let Self { rays, layout, store_steps, stores, replayed, .. } = self;
        let ray = &mut rays[ray as usize];
        ray.steps.change(|steps, policy, _| store_steps.leave_out(steps, policy, layout, (stores, replayed)));
    }

    /// Answers a skipped ray of which no step is left, if decisions fall with the hit; whether that was so.
    pub(crate) fn answer(&mut self, chunk: &Chunk, index: usize) -> Result<bool, StreamFault> {
        let spec = &self.shadow_cache;
        if !spec.decide.answers(chunk.head(index).decision, 0) {
            return Ok(false);
        }
        let ray = chunk.ray(index);
        let left = ray.packed_policy().iter().filter(|&&word| spec.performs(word)).count();
        if !spec.decide.answers(ray.head.decision, left) {
            return Ok(false);
        }
        for &word in ray.packed_policy() {
            check_step(word, &self.layout)?;
            self.store_steps.count_left_out(word, &mut self.stores, &mut self.replayed);
        }
        self.stores.answered_rays += 1;
        self.replayed.shadow_rays += 1;
        self.replayed.shadow_rays_skipped += 1;
        Ok(true)
    }

    /// The ray has done its path.
    pub(crate) fn retire(&mut self, ray: RayId) {
        let Ray { kind, place, hit, siblings, ref mut steps, .. } = self.rays[ray as usize];
        self.stores.gathered_writes += steps.change(|steps, path_end, _| {
            let ray = Retiring { kind, hit: HitId { chunk: place.chunk, place: hit }, siblings, steps, path_end };
            self.gathering.retire(ray, self.layout.stores())
        });
    }

    /// A fetch of a node, not begun yet.
    #[inline]
    pub(crate) fn node_fetch(&self, node: NodeId) -> Fetch {
        match self.layout.node_lines() {
            Some(lines) => Fetch::of_node(lines.of(node), lines.bytes),
            None => Fetch::of(&self.layout.node(node), &self.layout),
        }
    }

    /// The entry of a ray's next step.
    pub(crate) fn entry_element(&self, ray: RayId) -> Element {
        let step = self.rays[ray as usize].step().expect("the ray has a step of an entry");
        let (store, index) = step.entry().expect("the step is of an entry");
        self.layout.entry(store, index, step.writes())
    }

    /// Whether a ray's next step is a first touch that sets modes: then the ray's next steps are those that do.
    pub(crate) fn first_touch(&mut self, ray: RayId) -> bool {
        let Self { rays, layout, store_steps, stores, .. } = self;
        let ray = &mut rays[ray as usize];
        let setting = ray.steps.change(|steps, _, next| store_steps.first_touch(steps, next, layout, stores));
        let Some(setting) = setting else { return false };
        ray.evaluating = setting;
        true
    }

    /// A frame's end with these recorded steps begins; whether there is anything to do.
    pub(crate) fn begin_end(&mut self, recorded: &[u32], now: u64) -> bool {
        let spec = self.shadow_cache;
        let Self { layout, store_steps, stores, replayed, .. } = self;
        let steps = store_steps.end(recorded, layout, (stores, replayed));
        let register = spec.register.get() > 0 && spec.place != Place::Free;
        if steps.is_empty() && !register {
            return false;
        }
        let mut parts = vec![Vec::new(); self.parts.shadow_cache as usize];
        for step in steps {
            let unit = step.entry().map_or(0, |(store, index)| self.home(store, index));
            parts[unit as usize].push(step);
        }
        for (unit, steps) in parts.into_iter().enumerate() {
            self.frame_end[unit] = Some((now + 1, steps));
            self.clock.wake(self.parts.shadow_cache(unit as u32), now + 1);
        }
        self.units_at_the_end = self.parts.shadow_cache;
        true
    }

    /// The first cycle beyond those that a unit which works in cycle `now` may work ahead to. A unit ahead counts a
    /// cycle beyond its work where rays get a line one by one: it stops two cycles before one that is looked at.
    #[inline]
    pub(crate) fn reach(&self, now: u64) -> u64 {
        now + self.horizon.min(self.looked_at.saturating_sub(now + 2)) + 1
    }

    /// A shadow-cache unit's steps of a frame's end that has begun.
    pub(crate) fn hear_of_the_end(&mut self, unit: u32, now: u64) -> Option<Vec<Step>> {
        let part = &mut self.frame_end[unit as usize];
        part.take_if(|(at, _)| *at <= now).map(|(_, steps)| steps)
    }

    /// A frame begins: lines of the dynamic part go from the L2.
    pub(crate) fn begin_frame(&mut self, frame: &FrameInfo) {
        self.layout.begin_frame(frame);
        let (shortest, list) = self.latencies;
        self.horizon = if self.layout.has_lists() { shortest.min(list) } else { shortest };
        let first = self.layout.dynamic_part();
        self.l2.banks.iter_mut().for_each(|bank| bank.drop_from(first));
        let Self { port, layout, clock, .. } = self;
        if let Some(port) = port {
            port.begin_frame(frame, layout, clock.now(), clock);
        }
    }

    /// Whether the host's port lets a ray be handed over in cycle `now`.
    pub(crate) fn port_lets_in(&self, now: u64) -> bool {
        self.port.as_ref().is_none_or(|port| port.lets_in(now))
    }

    /// Whether it lets the frame's end begin in cycle `now`.
    pub(crate) fn port_lets_end(&self, now: u64) -> bool {
        self.port.as_ref().is_none_or(|port| port.lets_end(now))
    }

    /// A ray comes back to traversal unit `unit`, from an operation of part `from` that ends in cycle `ends`.
    pub(crate) fn send_back(&mut self, ray: RayId, unit: u32, from: PartId, ends: u64) {
        let (at, turn) = (ends + 1, self.parts.turn(from, ends));
        self.returned[unit as usize].insert_by_key(Back { at, turn, ray }, |back| (back.at, back.turn));
        self.post(unit, at);
    }

    /// Something comes to traversal unit `unit` in cycle `at`.
    #[inline]
    pub(crate) fn post(&mut self, unit: u32, at: u64) {
        let wakes = &mut self.wakes[unit as usize];
        if at < *wakes {
            *wakes = at;
            self.clock.wake(self.parts.traversal(unit), at);
        }
    }

    /// Cycle `now` of bank `index` of the L2.
    #[inline]
    pub(crate) fn tick_bank(&mut self, index: usize, now: u64) {
        let Self { parts, l2, dram, clock, lines, .. } = self;
        l2.banks[index].tick(now, dram, clock, |to, line, at| {
            let first = ((at - 1) % u64::from(parts.banks)) as u32;
            let turn = (index as u32 + parts.banks - first) % parts.banks;
            lines[to.0 as usize].insert_by_key(Answer { at, turn, line }, |answer| (answer.at, answer.turn));
        });
    }

    /// Cycle `now` of the host's port to the DRAM.
    pub(crate) fn tick_port(&mut self, now: u64) {
        let Self { port, dram, clock, .. } = self;
        if let Some(port) = port {
            port.tick(now, dram, clock);
        }
    }

    /// Cycle `now` of channel `index` of the DRAM.
    #[inline]
    pub(crate) fn tick_channel(&mut self, index: usize, now: u64) {
        let Self { parts, l2, dram, clock, .. } = self;
        let first = parts.bank(0).0;
        dram.tick(index, now, clock, |to, line| {
            // What comes for the host's port, whose number is after the banks', is gone from the machine.
            if let Some(bank) = l2.banks.get_mut((to.0 - first) as usize) {
                bank.deliver(line, now + 1);
            }
        });
    }
}
