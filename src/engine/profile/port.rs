//! The host's port to the DRAM, without a queue of its own: its lines are requested at once. Rays wait until the lines
//! not yet moved fit into the queues.

use std::collections::VecDeque;

use super::memory::Memory;
use super::watch::Watch;
use crate::engine::tally::PortTally;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::machine::traffic::{HostTraffic, Run, TrafficSpec};
use crate::quantity::LineAddr;
use crate::stream::{FrameInfo, RayKind};

/// The port.
#[derive(Clone, Debug)]
pub(super) struct Port {
    spec: TrafficSpec,
    clock_mhz: u64,
    traffic: HostTraffic,
    /// Lines that the queues hold: the port's queue and the queues of all channels.
    places: usize,
    /// When each of the last `places` lines has passed.
    passed: VecDeque<u64>,
    /// When all lines so far have passed.
    empty_at: u64,
    built_at: u64,
    /// The requests to the DRAM.
    pub counts: PortTally,
}

impl Port {
    /// The idle port of `machine`; `None` if its host has no traffic of its own.
    pub(super) fn new(machine: &MachineSpec) -> Option<Self> {
        Some(Self {
            spec: machine.traffic,
            clock_mhz: machine.clock_mhz.get(),
            traffic: HostTraffic::new(&machine.traffic, machine.line_bytes.get())?,
            places: machine.traffic.queue.size() + machine.dram.queue.size() * machine.dram.channels.size(),
            passed: VecDeque::new(),
            empty_at: 0,
            built_at: 0,
            counts: PortTally::default(),
        })
    }

    /// A frame begins in cycle `at`.
    pub(super) fn begin_frame<W: Watch>(
        &mut self,
        frame: &FrameInfo,
        layout: &Layout,
        at: u64,
        memory: &mut Memory<W>,
    ) {
        let at = at.max(self.lets_end_at());
        self.built_at = at + self.spec.build_cycles(frame, self.clock_mhz);
        let runs = self.traffic.built(layout.dynamic_arrays());
        runs.for_each(|run| self.ask(run, at, memory));
    }

    /// A ray is handed over in cycle `at`.
    pub(super) fn hand_over<W: Watch>(&mut self, at: u64, memory: &mut Memory<W>) {
        let run = self.traffic.ray();
        run.into_iter().for_each(|run| self.ask(run, at, memory));
    }

    /// The host takes the results of a ray in cycle `at`.
    pub(super) fn take_results<W: Watch>(&mut self, kind: RayKind, path: &[u32], at: u64, memory: &mut Memory<W>) {
        let runs = self.traffic.result(kind, path);
        runs.for_each(|run| self.ask(run, at, memory));
    }

    fn ask<W: Watch>(&mut self, run: Run, at: u64, memory: &mut Memory<W>) {
        self.counts.count(&run);
        for line in (run.first.0..run.first.0 + run.lines).map(LineAddr) {
            let passed = memory.ask_dram(line, run.class, run.write, at);
            self.empty_at = self.empty_at.max(passed);
            self.passed.push_back(passed);
            if self.passed.len() > self.places {
                self.passed.pop_front();
            }
        }
    }

    /// The first cycle in which a ray can be handed over.
    pub(super) fn lets_in_at(&self) -> u64 {
        let oldest = self.passed.front().filter(|_| self.passed.len() == self.places);
        self.built_at.max(oldest.copied().unwrap_or(0))
    }

    /// The first cycle in which the end-of-frame update can begin, or the frame be over.
    pub(super) fn lets_end_at(&self) -> u64 {
        self.built_at.max(self.empty_at)
    }
}
