//! What lies between the parts of the machine: rays in flight, queues between units, the shared memory, and the alarm
//! clock that wakes parts.

use std::collections::VecDeque;

use super::layout::Layout;
use super::ray::{Ray, RayId};
use super::spec::MachineSpec;
use crate::memory::bank::L2;
use crate::memory::dram::Dram;
use crate::memory::queue::Queue;
use crate::memory::{PartId, Wake};
use crate::quantity::LineAddr;
use crate::stream::{Header, Totals};

/// The numbers of the parts, in the order in which they act in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    /// Traversal units.
    pub traversal: u32,
    /// Intersection units.
    pub intersection: u32,
    /// Banks of the L2.
    pub banks: u32,
    /// Channels of the DRAM.
    pub channels: u32,
}

impl Parts {
    /// The parts of a machine.
    pub fn new(spec: &MachineSpec) -> Self {
        Self {
            traversal: spec.traversal.count.get() as u32,
            intersection: spec.intersection.count.get() as u32,
            banks: spec.l2.banks.get() as u32,
            channels: spec.dram.channels.get() as u32,
        }
    }

    /// The dispatcher.
    pub const DISPATCHER: PartId = PartId(0);

    /// Traversal unit `index`.
    pub fn traversal(&self, index: u32) -> PartId {
        PartId(1 + index)
    }

    /// Intersection unit `index`.
    pub fn intersection(&self, index: u32) -> PartId {
        PartId(1 + self.traversal + index)
    }

    /// The shadow-cache unit.
    pub fn shadow_cache(&self) -> PartId {
        self.intersection(self.intersection)
    }

    /// Bank `index` of the L2.
    pub fn bank(&self, index: u32) -> PartId {
        PartId(self.shadow_cache().0 + 1 + index)
    }

    /// Channel `index` of the DRAM.
    pub fn channel(&self, index: u32) -> PartId {
        PartId(self.bank(self.banks).0 + index)
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.channel(self.channels).0 as usize
    }
}

/// A queue with a place for everything that can come.
pub type Inbox<T> = VecDeque<(u64, T)>;

/// Takes the first of `inbox` if it is there in cycle `now`.
pub fn take<T: Copy>(inbox: &mut Inbox<T>, now: u64) -> Option<T> {
    let (_, entry) = *inbox.front().filter(|(at, _)| *at <= now)?;
    inbox.pop_front();
    Some(entry)
}

/// What the parts share. `W` wakes them.
#[derive(Clone, Debug)]
pub struct Links<W> {
    /// The parts' numbers.
    pub parts: Parts,
    /// The pool's rays, then the steps of a frame's end.
    pub rays: Vec<Ray>,
    /// Addresses.
    pub layout: Layout,
    /// Rays from the dispatcher to each traversal unit.
    pub dispatched: Vec<Inbox<RayId>>,
    /// Rays from intersection units back to each traversal unit.
    pub returned: Vec<Inbox<RayId>>,
    /// Rays to each intersection unit.
    pub tests: Vec<Queue<RayId>>,
    /// Rays back from intersection units to the shadow-cache unit.
    pub tested: Inbox<RayId>,
    /// Retired and skipped rays to the shadow-cache unit.
    pub retired: Inbox<RayId>,
    /// Rays that are done, to the dispatcher.
    pub done: Vec<RayId>,
    /// Traversal units in which a slot was freed, to the dispatcher.
    pub freed: Vec<u32>,
    /// The steps of the frame's end, to the shadow-cache unit.
    pub frame_end: Option<(u64, std::sync::Arc<Vec<u32>>)>,
    /// Whether the steps of the frame's end are done, to the dispatcher.
    pub frame_over: bool,
    /// Lines from the L2, to the L1 of each part.
    pub lines: Vec<Inbox<LineAddr>>,
    /// The L2.
    pub l2: L2,
    /// The DRAM.
    pub dram: Dram,
    /// What was replayed of the frame so far.
    pub replayed: Totals,
    /// Wakes parts.
    pub clock: W,
}

impl<W: Wake> Links<W> {
    /// Empty links of a machine that replays a stream.
    pub fn new(spec: &MachineSpec, header: &Header, clock: W) -> Self {
        let parts = Parts::new(spec);
        let line = spec.line_bytes.get();
        let entries = spec.dispatcher.rays.size() + spec.shadow_cache.contexts.size();
        Self {
            parts,
            rays: vec![Ray::default(); entries],
            layout: Layout::new(header, line),
            dispatched: vec![Inbox::new(); parts.traversal as usize],
            returned: vec![Inbox::new(); parts.traversal as usize],
            tests: vec![Queue::new(spec.intersection.queue.size()); parts.intersection as usize],
            tested: Inbox::new(),
            retired: Inbox::new(),
            done: Vec::new(),
            freed: Vec::new(),
            frame_end: None,
            frame_over: false,
            lines: vec![Inbox::new(); parts.count()],
            l2: spec.l2.build(parts.bank(0), line),
            dram: Dram::new(&spec.dram, spec.clock_mhz.get(), line, parts.channel(0)),
            replayed: Totals::default(),
            clock,
        }
    }

    /// Sends a ray to its intersection unit, if that has a place; else `from` is woken when it has.
    pub fn send_to_test(&mut self, ray: RayId, home: u32, from: PartId, now: u64) -> bool {
        let unit = home % self.parts.intersection;
        let queue = &mut self.tests[unit as usize];
        if !queue.has_room(now) {
            queue.wait_for_room(from, now, &mut self.clock);
            return false;
        }
        queue.put(ray, now + 1);
        self.clock.wake(self.parts.intersection(unit), now + 1);
        true
    }

    /// A ray is done.
    pub fn done(&mut self, ray: RayId, now: u64) {
        self.done.push(ray);
        self.clock.wake(Parts::DISPATCHER, now + 1);
    }

    /// Sends a ray to the shadow-cache unit.
    pub fn send_to_shadow_cache(&mut self, ray: RayId, now: u64) {
        self.retired.push_back((now + 1, ray));
        self.clock.wake(self.parts.shadow_cache(), now + 1);
    }

    /// A frame begins: lines of the dynamic part go from the L2.
    pub fn drop_dynamic_lines(&mut self) {
        let first = self.layout.dynamic_part();
        self.l2.banks.iter_mut().for_each(|bank| bank.drop_from(first));
    }

    /// Cycle `now` of bank `index` of the L2.
    pub fn tick_bank(&mut self, index: usize, now: u64) {
        let Self { l2, dram, clock, lines, .. } = self;
        l2.banks[index].tick(now, dram, clock, |to, line| lines[to.0 as usize].push_back((now + 1, line)));
    }

    /// Cycle `now` of channel `index` of the DRAM.
    pub fn tick_channel(&mut self, index: usize, now: u64) {
        let Self { parts, l2, dram, clock, .. } = self;
        let first = parts.bank(0).0;
        dram.tick(index, now, clock, |to, line| l2.banks[(to.0 - first) as usize].deliver(line, now + 1));
    }
}
