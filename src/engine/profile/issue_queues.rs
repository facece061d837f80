//! Issue queues: how rays move from unit to unit, without a simulation of each cycle. Each unit sends one ray per cycle
//! and takes one on; it has contexts and a queue in front of them. A full queue blocks the head of the sender's output
//! queue and all behind it (head-of-line blocking). The order of rays decides which rays run together, and so what the
//! L1s miss.

use std::collections::VecDeque;
use std::ops::Range;

use crate::engine::part_set::PartSet;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;

/// A ray that a unit takes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Taken {
    /// The ray.
    pub ray: u32,
    /// The unit.
    pub unit: usize,
    /// The cycle.
    pub at: u64,
}

/// The interface of a unit to other units.
#[derive(Clone, Debug)]
struct Gate {
    /// Free contexts; `u64::MAX` at first if they are not limited.
    contexts: u64,
    /// Rays that wait for a context, and the places of that queue.
    queue: VecDeque<u32>,
    places: usize,
    /// The first cycles in which the next ray can come in, and the next can be sent.
    arrive_at: u64,
    send_at: u64,
    /// Rays that can come in per cycle, and the number that came in cycle `came_at`.
    width: u64,
    came: u64,
    came_at: u64,
    /// Rays that leave, each with its destination.
    leaving: VecDeque<(u32, u32)>,
    /// Units whose first leaving ray waits for a place here.
    waiting: PartSet,
}

/// All units.
#[derive(Clone, Debug)]
pub(super) struct IssueQueues {
    gates: Vec<Gate>,
    first_of_kind: [usize; Kind::ALL.len() + 1],
    cores: usize,
    taken: VecDeque<Taken>,
}

impl IssueQueues {
    /// The units of `machine`, ordered by kind, then by core.
    pub(super) fn new(machine: &MachineSpec) -> Self {
        let specs = Kind::ALL.map(|kind| kind.spec(machine));
        let units = specs.iter().map(|spec| spec.count as usize).sum();
        let (mut gates, mut first_of_kind) = (Vec::new(), [0; Kind::ALL.len() + 1]);
        for (index, spec) in specs.into_iter().enumerate() {
            let gate = Gate {
                contexts: spec.contexts.unwrap_or(u64::MAX),
                queue: VecDeque::new(),
                places: spec.places.map_or(usize::MAX, |places| places as usize),
                arrive_at: 0,
                send_at: 0,
                width: spec.width,
                came: 0,
                came_at: 0,
                leaving: VecDeque::new(),
                waiting: PartSet::new(units),
            };
            gates.resize(gates.len() + spec.count as usize, gate);
            first_of_kind[index + 1] = gates.len();
        }
        Self { gates, first_of_kind, cores: machine.cores.size(), taken: VecDeque::new() }
    }

    /// The units of a kind.
    pub(super) fn of_kind(&self, kind: Kind) -> Range<usize> {
        self.first_of_kind[kind as usize]..self.first_of_kind[kind as usize + 1]
    }

    /// The kind of a unit.
    pub(super) fn kind(&self, unit: usize) -> Kind {
        let after = |kind: &Kind| unit < self.first_of_kind[*kind as usize + 1];
        Kind::ALL.into_iter().find(after).expect("units are numbered through")
    }

    /// The core of a unit.
    pub(super) fn core(&self, unit: usize) -> usize {
        let units = self.of_kind(self.kind(unit));
        (unit - units.start) * self.cores / units.len()
    }

    /// The unit of a kind in the core of unit `from` that works for the ray with number `home`.
    pub(super) fn performer(&self, kind: Kind, from: usize, home: usize) -> usize {
        let units = self.of_kind(kind);
        let a_core = units.len() / self.cores;
        units.start + self.core(from) * a_core + home % a_core
    }

    /// The next ray that a unit has taken on.
    pub(super) fn taken(&mut self) -> Option<Taken> {
        self.taken.pop_front()
    }

    /// A ray comes to a unit in cycle `at`. The caller has checked for room.
    pub(super) fn arrive(&mut self, ray: u32, unit: usize, at: u64) {
        let gate = &mut self.gates[unit];
        if gate.contexts == 0 {
            return gate.queue.push_back(ray);
        }
        gate.contexts -= 1;
        self.take_on(ray, unit, at);
    }

    fn take_on(&mut self, ray: u32, unit: usize, at: u64) {
        let gate = &mut self.gates[unit];
        let at = at.max(gate.arrive_at);
        gate.came = if at == gate.came_at { gate.came + 1 } else { 1 };
        gate.came_at = at;
        gate.arrive_at = if gate.came < gate.width { at } else { at + 1 };
        self.taken.push_back(Taken { ray, unit, at });
    }

    /// A ray of unit `from` goes to unit `to`, from cycle `now` on.
    pub(super) fn send(&mut self, ray: u32, from: usize, to: usize, now: u64) {
        self.gates[from].leaving.push_back((ray, to as u32));
        if self.gates[from].leaving.len() == 1 {
            self.send_on(from, now);
        }
    }

    /// Sends the first leaving rays of a unit, one per cycle, while there are places for them.
    fn send_on(&mut self, from: usize, now: u64) {
        while let Some(&(ray, to)) = self.gates[from].leaving.front() {
            let gate = &mut self.gates[to as usize];
            if gate.queue.len() >= gate.places {
                return gate.waiting.add(from as u32);
            }
            let sender = &mut self.gates[from];
            let at = now.max(sender.send_at);
            sender.send_at = at + 1;
            sender.leaving.pop_front();
            self.arrive(ray, to as usize, at + 1);
        }
    }

    /// A context of a unit becomes free in cycle `now`.
    pub(super) fn leave(&mut self, unit: usize, now: u64) {
        self.gates[unit].contexts += 1;
        let Some(next) = self.gates[unit].queue.pop_front() else { return };
        self.gates[unit].contexts -= 1;
        self.take_on(next, unit, now);
        if let Some(sender) = self.next_sender(unit, now + 1) {
            self.gates[unit].waiting.remove(sender);
            self.send_on(sender as usize, now + 1);
        }
    }

    /// The unit whose ray gets a place that is free in cycle `at`: units of a kind act in rotating order.
    fn next_sender(&self, unit: usize, at: u64) -> Option<u32> {
        let waiting = &self.gates[unit].waiting;
        Kind::ALL.into_iter().find_map(|kind| {
            let (first, end) = (self.of_kind(kind).start as u32, self.of_kind(kind).end as u32);
            let middle = first + (at % u64::from(end - first)) as u32;
            waiting.next(middle, end).or_else(|| waiting.next(first, middle))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranged::Within;

    #[test]
    fn a_full_queue_holds_up_who_goes_elsewhere() {
        let mut machine = MachineSpec::default();
        machine.traversal.count = const { Within::literal(2) };
        machine.intersection.count = const { Within::literal(2) };
        machine.intersection.tests = const { Within::literal(1) };
        machine.intersection.queue = const { Within::literal(1) };
        let mut issue_queues = IssueQueues::new(&machine);
        let first = issue_queues.of_kind(Kind::Intersection).start;
        // Rays 0 and 1 fill the first unit. Rays 2 and 3 wait for it, one in each traversal unit. Ray 4 is for the
        // second unit but waits behind ray 2.
        for (ray, from, to) in [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 1, 0), (4, 0, 1)] {
            issue_queues.send(ray, from, first + to, 10);
        }
        let taken = |issue_queues: &mut IssueQueues| std::iter::from_fn(|| issue_queues.taken()).collect::<Vec<_>>();
        let of = |ray, unit, at| Taken { ray, unit: first + unit, at };
        assert_eq!(taken(&mut issue_queues), [of(0, 0, 11)]);
        // The place is free in cycle 21, in which the second traversal unit acts first.
        issue_queues.leave(first, 20);
        assert_eq!(taken(&mut issue_queues), [of(1, 0, 20)]);
        issue_queues.leave(first, 30);
        assert_eq!(taken(&mut issue_queues), [of(3, 0, 30), of(4, 1, 33)]);
    }
}
