//! The host's own lines: the bytes that every machine moves, and the cycles that the channels need for them.

use super::sums::Sums;
use crate::machine::MachineSpec;
use crate::machine::layout::Layout;
use crate::machine::traffic::{HostTraffic, Run};
use crate::memory::dram::spec::Model;
use crate::quantity::{Bytes, LineAddr};
use crate::stream::{FrameInfo, Ray};

/// The host's requests to the DRAM in a phase.
#[derive(Clone, Debug)]
pub(super) struct HostWork {
    traffic: Option<HostTraffic>,
    machine: MachineSpec,
    /// Lines per channel.
    channels: Vec<u64>,
    /// Cycles in which the frame's dynamic part is built.
    pub building: u64,
}

impl HostWork {
    /// The host work of `machine`, before a stream begins.
    pub(super) fn new(machine: &MachineSpec) -> Self {
        Self {
            traffic: HostTraffic::new(&machine.traffic, machine.line_bytes.get()),
            machine: machine.clone(),
            channels: vec![0; machine.dram.channels.size()],
            building: 0,
        }
    }

    /// A frame begins.
    pub(super) fn begin_frame(&mut self, info: &FrameInfo, layout: &Layout, sums: &mut Sums) {
        self.building = self.machine.traffic.build_cycles(info, self.machine.clock_mhz.get());
        let Some(traffic) = &mut self.traffic else { return };
        let runs = traffic.built(layout.dynamic_arrays());
        runs.for_each(|run| self.add(run, sums));
    }

    /// A ray goes to the accelerator and comes back.
    pub(super) fn ray(&mut self, ray: &Ray<'_>, sums: &mut Sums) {
        let Some(traffic) = &mut self.traffic else { return };
        let runs = traffic.ray().into_iter().chain(traffic.result(ray.head.kind, ray.packed_path()));
        runs.for_each(|run| self.add(run, sums));
    }

    fn add(&mut self, Run { class, write, first, lines }: Run, sums: &mut Sums) {
        sums.dram[class as usize] += Bytes(lines * self.machine.line_bytes.get());
        sums.host_lines += lines;
        sums.host_reads += if write { 0 } else { lines };
        for line in (first.0..first.0 + lines).map(LineAddr) {
            self.channels[self.machine.dram.place(line).channel] += 1;
        }
    }

    /// Minimum cycles of the channels for the host's lines of the phase and the `others` lines of each channel. The
    /// host's last lines may still be in a channel when the phase is over.
    pub(super) fn least(&self, others: &[u64]) -> u64 {
        let Some((bytes, cycles)) = self.machine.dram.channel_peak(self.machine.clock_mhz.get()) else { return 0 };
        let under_way = self.machine.dram.queue.get() + self.in_transfer();
        let lines = self.channels.iter().zip(others).map(|(host, others)| others + host.saturating_sub(under_way));
        lines.max().unwrap_or(0) * self.machine.line_bytes.get() * cycles / bytes
    }

    /// Maximum lines of a channel whose last command is given but whose data has not passed.
    fn in_transfer(&self) -> u64 {
        let Model::Banks = self.machine.dram.model else { return 1 };
        let timing = &self.machine.dram.part.timing;
        let latency = timing.cl.get().max(timing.cwl.get());
        // Bursts follow one another: those that begin within the latency, the burst on the bus, and one for the
        // rounding to machine cycles.
        latency.div_ceil(self.machine.dram.part.burst_clocks.get()) + 2
    }

    /// Another phase begins.
    pub(super) fn end_phase(&mut self) {
        self.channels.fill(0);
        self.building = 0;
    }
}
