//! The host's port to the DRAM (rules H): lines of the host's own traffic, on their way to the channels.

use super::ray::Ray;
use super::wheel::Wheel;
use crate::engine::tally::PortTally;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::machine::parts::Parts;
use crate::machine::traffic::{HostTraffic, Run, TrafficSpec};
use crate::memory::dram::Dram;
use crate::memory::ring::Ring;
use crate::memory::{PartId, Request, Wake};
use crate::quantity::{Bytes, LineAddr};
use crate::stream::FrameInfo;

/// The port.
#[derive(Clone, Debug)]
pub(crate) struct Port {
    part: PartId,
    spec: TrafficSpec,
    clock_mhz: u64,
    line: Bytes,
    /// Number of lines that it can put into the DRAM's queues in a cycle.
    width: usize,
    traffic: HostTraffic,
    /// Runs of lines, each with the first cycle in which it can be put; and the number of lines in all runs.
    runs: Ring<(u64, Run)>,
    waiting: u64,
    /// The cycle in which the frame's dynamic part is built.
    built_at: u64,
    counts: PortTally,
}

impl Port {
    /// The idle port of `machine`; `None` if its host has no traffic of its own.
    pub(crate) fn new(machine: &MachineSpec, parts: &Parts) -> Option<Self> {
        Some(Self {
            part: parts.port(),
            spec: machine.traffic,
            clock_mhz: machine.clock_mhz.get(),
            line: Bytes(machine.line_bytes.get()),
            width: machine.dram.channels.size(),
            traffic: HostTraffic::new(&machine.traffic, machine.line_bytes.get())?,
            runs: Ring::new(),
            waiting: 0,
            built_at: 0,
            counts: PortTally::default(),
        })
    }

    /// A frame begins in cycle `now`.
    pub(crate) fn begin_frame(&mut self, frame: &FrameInfo, layout: &Layout, now: u64, clock: &mut Wheel) {
        self.built_at = now + self.spec.build_cycles(frame, self.clock_mhz);
        let runs = self.traffic.built(layout.dynamic_arrays());
        runs.for_each(|run| self.put(run, now, clock));
    }

    /// A ray is handed over in cycle `now`.
    pub(crate) fn hand_over(&mut self, now: u64, clock: &mut Wheel) {
        if let Some(run) = self.traffic.ray() {
            self.put(run, now, clock);
        }
    }

    /// The host takes the results of a ray in cycle `now`.
    pub(crate) fn take_results(&mut self, ray: &Ray, now: u64, clock: &mut Wheel) {
        let runs = self.traffic.result(ray.kind, ray.steps.path());
        runs.for_each(|run| self.put(run, now, clock));
    }

    fn put(&mut self, run: Run, now: u64, clock: &mut Wheel) {
        self.runs.push_back((now + 1, run));
        self.waiting += run.lines;
        self.counts.count(&run);
        clock.wake(self.part, now + 1);
    }

    /// Whether a ray can be handed over in cycle `now`.
    pub(crate) fn lets_in(&self, now: u64) -> bool {
        now >= self.built_at && self.waiting < self.spec.queue.get()
    }

    /// Whether the frame's end can begin in cycle `now`.
    pub(crate) fn lets_end(&self, now: u64) -> bool {
        now >= self.built_at && self.waiting == 0
    }

    /// The cycle in which the frame's dynamic part is built.
    pub(crate) fn built_at(&self) -> u64 {
        self.built_at
    }

    /// Acts in cycle `now`.
    pub(crate) fn tick(&mut self, now: u64, dram: &mut Dram, clock: &mut Wheel) {
        let before = self.waiting;
        let mut finds_room = true;
        for _ in 0..self.width {
            let Some((_, run)) = self.runs.get_mut(0).filter(|(at, _)| *at <= now) else { break };
            let Run { class, write, first: line, .. } = *run;
            let request = Request { line, class, write, bytes: self.line, from: self.part, attributed: false };
            finds_room = dram.put(request, now, clock);
            if !finds_room {
                break;
            }
            self.waiting -= 1;
            (run.first, run.lines) = (LineAddr(line.0 + 1), run.lines - 1);
            if run.lines == 0 {
                self.runs.drop_front();
            }
        }
        if self.waiting > 0 && finds_room {
            clock.wake(self.part, now + 1);
        }
        let lets = |waiting: u64| (waiting < self.spec.queue.get(), waiting == 0);
        if lets(self.waiting) != lets(before) {
            clock.wake(Parts::DISPATCHER, now + 1);
        }
    }

    /// Lines that it requested from the DRAM.
    pub(crate) fn counts(&self) -> &PortTally {
        &self.counts
    }

    /// The state of its queue, for the report of a deadlock.
    pub(crate) fn queues(&self) -> String {
        format!("lines {}/{}, the scene is built in cycle {}", self.waiting, self.spec.queue, self.built_at)
    }
}
