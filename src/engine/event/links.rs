//! State that the parts share: rays in flight, queues between units, the shared memory, and the timing wheel that
//! wakes parts.

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

/// An unbounded queue of entries, each with the cycle in which it arrives.
pub(super) type Inbox<T> = Ring<(u64, T)>;

/// Takes the first entry of `inbox` if it has arrived by cycle `now`.
#[inline]
pub(super) fn take<T: Copy>(inbox: &mut Inbox<T>, now: u64) -> Option<T> {
    let &(at, entry) = inbox.front()?;
    if at > now {
        return None;
    }
    inbox.drop_front();
    Some(entry)
}

/// A ray that returns to its traversal unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Back {
    /// The cycle in which it arrives.
    pub at: u64,
    /// The sending unit's position in the round robin of the cycle before, which orders the arrivals of a cycle.
    turn: u32,
    /// The ray.
    pub ray: RayId,
}

/// A line from the L2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    /// The cycle in which it arrives.
    pub at: u64,
    /// The sending bank's position in the round robin of the cycle before, which orders the arrivals of a cycle.
    turn: u32,
    /// The line.
    pub line: LineAddr,
}

/// The state that the parts share.
#[derive(Clone, Debug)]
pub(crate) struct Links {
    /// The parts' numbers.
    pub parts: Parts,
    /// Rays of the pool, then entries for end-of-frame steps.
    pub rays: Vec<Ray>,
    /// The memory layout.
    pub layout: Layout,
    /// Rays from the dispatcher to each traversal unit.
    pub dispatched: Vec<Inbox<RayId>>,
    /// Rays that return from list, intersection and division units to each traversal unit. Each is known from the
    /// cycle in which its last operation there begins.
    pub returned: Vec<Ring<Back>>,
    /// The lookahead: what comes to a traversal unit, and is not yet known, is more than this number of cycles away.
    horizon: u64,
    /// The next cycle that the feed observes.
    pub looked_at: u64,
    /// The next cycle in which each traversal unit is sure to act.
    pub wakes: Vec<u64>,
    /// Rays to each list unit.
    pub lists: Vec<Queue<RayId>>,
    /// Rays that return from intersection and division units to each list unit.
    pub listed: Vec<Inbox<RayId>>,
    /// Number of contexts of each list unit that other units freed.
    pub freed_lists: Vec<usize>,
    /// Rays to each intersection unit.
    pub tests: Vec<Queue<RayId>>,
    /// Number of contexts of each intersection unit that division units freed.
    pub freed_tests: Vec<usize>,
    /// Rays to each division unit.
    pub divisions: Vec<Queue<RayId>>,
    /// Rays that return from intersection units to each shadow-cache unit.
    pub back_in_policy: Vec<Inbox<RayId>>,
    /// Rays to each shadow-cache unit: retired and skipped rays, and rays from other shadow-cache units.
    pub retired: Vec<Inbox<RayId>>,
    /// The out FIFO: rays that are done, on their way to the host.
    pub done: Queue<RayId>,
    /// Traversal units that freed a slot, for the dispatcher.
    pub freed: Vec<u32>,
    /// The end-of-frame update of each shadow-cache unit: its first cycle, and its steps.
    pub frame_end: Vec<Option<(u64, Vec<Step>)>>,
    /// Number of units whose share of the end-of-frame update is not done.
    pub units_at_the_end: u32,
    /// Whether the end-of-frame update is done, for the dispatcher.
    pub frame_over: bool,
    /// Chooses the store steps of the policy that are performed.
    store_steps: StoreSteps,
    /// The shortest latency towards a traversal unit other than through a list unit, and the latency of a list unit.
    latencies: (u64, u64),
    /// Store steps that were performed otherwise than recorded.
    pub stores: StoreWork,
    /// The gather table.
    pub gathering: Gathering,
    /// The shadow-cache units' spec.
    pub shadow_cache: ShadowCacheSpec,
    /// Lines that banks of the L2 send to the L1 of each part, each with the cycle in which it arrives.
    pub lines: Vec<Ring<Answer>>,
    /// The L2.
    pub l2: L2,
    /// The host's port to the DRAM.
    pub port: Option<Port>,
    /// The DRAM.
    pub dram: Dram,
    /// Counts of what was replayed of the frame so far.
    pub replayed: Totals,
    /// The timing wheel that wakes parts.
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

    /// Removes the policy's steps that are not performed from a ray that is handed over, and counts them.
    pub(crate) fn leave_out(&mut self, ray: RayId) {
        let Self { rays, layout, store_steps, stores, replayed, .. } = self;
        let ray = &mut rays[ray as usize];
        ray.steps.change(|steps, policy, _| store_steps.leave_out(steps, policy, layout, (stores, replayed)));
    }

    /// With `decide: Hit`, answers a skipped ray that has no step to perform. Returns whether it did.
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

    /// The path of a ray is done: gathers its updates.
    pub(crate) fn retire(&mut self, ray: RayId) {
        let Ray { kind, place, hit, siblings, ref mut steps, .. } = self.rays[ray as usize];
        self.stores.gathered_writes += steps.change(|steps, path_end, _| {
            let ray = Retiring { kind, hit: HitId { chunk: place.chunk, place: hit }, siblings, steps, path_end };
            self.gathering.retire(ray, self.layout.stores())
        });
    }

    /// A fetch of a node, not begun.
    #[inline]
    pub(crate) fn node_fetch(&self, node: NodeId) -> Fetch {
        match self.layout.node_lines() {
            Some(lines) => Fetch::of_node(lines.of(node), lines.bytes),
            None => Fetch::of(&self.layout.node(node), &self.layout),
        }
    }

    /// The entry that a ray's next step accesses.
    pub(crate) fn entry_element(&self, ray: RayId) -> Element {
        let step = self.rays[ray as usize].step().expect("the ray has a step of an entry");
        let (store, index) = step.entry().expect("the step is of an entry");
        self.layout.entry(store, index, step.writes())
    }

    /// Inserts the steps that set modes if a ray's next step is a first touch. Returns whether it was one.
    pub(crate) fn first_touch(&mut self, ray: RayId) -> bool {
        let Self { rays, layout, store_steps, stores, .. } = self;
        let ray = &mut rays[ray as usize];
        let setting = ray.steps.change(|steps, _, next| store_steps.first_touch(steps, next, layout, stores));
        let Some(setting) = setting else { return false };
        ray.evaluating = setting;
        true
    }

    /// Begins the end-of-frame update, given its recorded steps. Returns whether there is anything to do.
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

    /// The first cycle that a unit acting in cycle `now` may not work ahead into. Where rays get a line one by one, a
    /// unit that works ahead counts one cycle beyond its work. It therefore stops two cycles before an observed cycle.
    #[inline]
    pub(crate) fn reach(&self, now: u64) -> u64 {
        now + self.horizon.min(self.looked_at.saturating_sub(now + 2)) + 1
    }

    /// Takes a shadow-cache unit's steps of an end-of-frame update that has begun by cycle `now`.
    pub(crate) fn hear_of_the_end(&mut self, unit: u32, now: u64) -> Option<Vec<Step>> {
        let part = &mut self.frame_end[unit as usize];
        part.take_if(|(at, _)| *at <= now).map(|(_, steps)| steps)
    }

    /// A frame begins: the L2 drops lines of the dynamic part.
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

    /// Whether the host's port lets the frame's end begin in cycle `now`.
    pub(crate) fn port_lets_end(&self, now: u64) -> bool {
        self.port.as_ref().is_none_or(|port| port.lets_end(now))
    }

    /// Sends a ray back to traversal unit `unit`, from an operation of part `from` that ends in cycle `ends`.
    pub(crate) fn send_back(&mut self, ray: RayId, unit: u32, from: PartId, ends: u64) {
        let (at, turn) = (ends + 1, self.parts.turn(from, ends));
        self.returned[unit as usize].insert_by_key(Back { at, turn, ray }, |back| (back.at, back.turn));
        self.post(unit, at);
    }

    /// Wakes traversal unit `unit` for cycle `at`, in which something arrives there.
    #[inline]
    pub(crate) fn post(&mut self, unit: u32, at: u64) {
        let wakes = &mut self.wakes[unit as usize];
        if at < *wakes {
            *wakes = at;
            self.clock.wake(self.parts.traversal(unit), at);
        }
    }

    /// Bank `index` of the L2 acts in cycle `now`.
    #[inline]
    pub(crate) fn tick_bank(&mut self, index: usize, now: u64) {
        let Self { parts, l2, dram, clock, lines, .. } = self;
        l2.banks[index].tick(now, dram, clock, |to, line, at| {
            let first = ((at - 1) % u64::from(parts.banks)) as u32;
            let turn = (index as u32 + parts.banks - first) % parts.banks;
            lines[to.0 as usize].insert_by_key(Answer { at, turn, line }, |answer| (answer.at, answer.turn));
        });
    }

    /// The host's port to the DRAM acts in cycle `now`.
    pub(crate) fn tick_port(&mut self, now: u64) {
        let Self { port, dram, clock, .. } = self;
        if let Some(port) = port {
            port.tick(now, dram, clock);
        }
    }

    /// Channel `index` of the DRAM acts in cycle `now`.
    #[inline]
    pub(crate) fn tick_channel(&mut self, index: usize, now: u64) {
        let Self { parts, l2, dram, clock, .. } = self;
        let first = parts.bank(0).0;
        dram.tick(index, now, clock, |to, line| {
            // A line for the host's port, whose number follows the banks', leaves the machine.
            if let Some(bank) = l2.banks.get_mut((to.0 - first) as usize) {
                bank.deliver(line, now + 1);
            }
        });
    }
}
