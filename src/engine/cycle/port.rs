//! The host's port to the DRAM (rules H).

use std::collections::VecDeque;

use super::link::Link;
use super::request::{DramRequest, Request};
use crate::engine::tally::PortTally;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::machine::traffic::{HostTraffic, Run, TrafficSpec};
use crate::memory::dram::spec::DramSpec;
use crate::quantity::{Bytes, LineAddr};
use crate::stream::{FrameInfo, RayKind};

pub(super) struct Port {
    spec: TrafficSpec,
    dram: DramSpec,
    clock_mhz: u64,
    line: Bytes,
    /// Its number as a requester of the DRAM, after all banks.
    index: usize,
    traffic: HostTraffic,
    /// Lines, each with the cycle from which it can go to its channel.
    lines: VecDeque<(u64, Request)>,
    /// The cycle from which the frame's dynamic part is available.
    built_at: u64,
    pub counts: PortTally,
}

impl Port {
    /// The port of `machine`, which has `banks` banks; `None` if its host has no traffic of its own.
    pub(super) fn new(machine: &MachineSpec, banks: usize) -> Option<Self> {
        let traffic = HostTraffic::new(&machine.traffic, machine.line_bytes.get())?;
        Some(Self {
            spec: machine.traffic,
            dram: machine.dram.clone(),
            clock_mhz: machine.clock_mhz.get(),
            line: Bytes(machine.line_bytes.get()),
            index: banks,
            traffic,
            lines: VecDeque::new(),
            built_at: 0,
            counts: PortTally::default(),
        })
    }

    pub(super) fn begin_frame(&mut self, now: u64, frame: &FrameInfo, layout: &Layout) {
        self.built_at = now + self.spec.build_cycles(frame, self.clock_mhz);
        let built = self.traffic.built(layout.dynamic_arrays());
        built.for_each(|run| self.put(now, run));
    }

    /// The dispatcher hands a ray over.
    pub(super) fn hand_over(&mut self, now: u64) {
        let ray = self.traffic.ray();
        ray.into_iter().for_each(|run| self.put(now, run));
    }

    /// The host takes the results of a ray.
    pub(super) fn take_results(&mut self, now: u64, kind: RayKind, path: &[u32]) {
        let result = self.traffic.result(kind, path);
        result.for_each(|run| self.put(now, run));
    }

    fn put(&mut self, now: u64, run: Run) {
        self.counts.count(&run);
        let Run { class, write, first, lines } = run;
        for line in (first.0..first.0 + lines).map(LineAddr) {
            self.lines.push_back((now + 1, Request { line, class, write, bytes: self.line, from: self.index }));
        }
    }

    /// Whether a ray can be handed over.
    pub(super) fn lets_in(&self, now: u64) -> bool {
        self.is_built(now) && (self.lines.len() as u64) < self.spec.queue.get()
    }

    /// Whether the end-of-frame update can begin.
    pub(super) fn lets_end(&self, now: u64) -> bool {
        self.is_built(now) && self.lines.is_empty()
    }

    /// Whether the frame's dynamic part is available.
    pub(super) fn is_built(&self, now: u64) -> bool {
        now >= self.built_at
    }

    pub(super) fn tick(&mut self, now: u64, to_channel: &mut [Link<DramRequest>]) {
        for _ in 0..to_channel.len() {
            let Some(&(at, request)) = self.lines.front() else { return };
            let place = self.dram.place(request.line);
            let channel = &mut to_channel[place.channel];
            if at > now || !channel.has_room() {
                return;
            }
            channel.put(now, DramRequest { request, place, activated: false, precharged: false, bursts_done: 0 });
            self.lines.pop_front();
        }
    }

    pub(super) fn queues(&self) -> String {
        format!("lines {}/{}, the scene is built in cycle {}", self.lines.len(), self.spec.queue, self.built_at)
    }
}
