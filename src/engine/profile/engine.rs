//! The simplified machine.

use super::agenda::Agenda;
use super::dispatch::{Dispatch, Given};
use super::division::Division;
use super::issue_queues::IssueQueues;
use super::memory::Memory;
use super::port::Port;
use super::unit::Unit;
use super::watch::Watch;
use super::whereabouts::{Stage, Whereabouts};
use crate::engine::contract::Engine;
use crate::engine::error::RunError;
use crate::engine::feed::Feed;
use crate::engine::tally::{Tally, busy};
use crate::engine::work::Holder;
use crate::machine::MachineSpec;
use crate::machine::division::DivisionSpec;
use crate::machine::kinds::{Kind, KindSpec};
use crate::machine::layout::Layout;
use crate::machine::shadow_cache::Place;
use crate::memory::dram::command::ChannelLog;
use crate::stream::Header;

/// The simplified machine.
pub(crate) struct Profile<W = ()> {
    /// The timing of division units.
    pub(super) division: DivisionSpec,
    /// Where the policy's stores are placed, which decides how accesses go.
    pub(super) place: Place,
    pub(super) cores: usize,
    pub(super) layout: Layout,
    pub dispatch: Dispatch,
    pub(super) rays: Vec<Whereabouts>,
    /// Units, as the issue queues number them.
    pub(super) units: Vec<Unit>,
    pub(super) issue_queues: IssueQueues,
    pub(super) divisions: Vec<Division>,
    pub(super) memory: Memory<W>,
    /// The host's port to the DRAM.
    pub(super) port: Option<Port>,
    pub(super) agenda: Agenda,
    /// The cycles in which the last two frames were over. A run never ends before the earlier of them.
    frames_over: [u64; 2],
    /// Whether the end of shading is on the agenda, under the number after all rays.
    shading: bool,
}

impl Profile {
    pub(crate) fn new(machine: &MachineSpec, header: &Header) -> Self {
        Self::watched(machine, header, ())
    }
}

impl<W: Watch> Profile<W> {
    /// The machine; `watch` receives all accesses.
    pub(crate) fn watched(machine: &MachineSpec, header: &Header, watch: W) -> Self {
        let line = machine.line_bytes.get();
        let issue_queues = IssueQueues::new(machine);
        let of_kind = |kind: Kind| {
            let spec = kind.spec(machine);
            let writes = if kind == Kind::Intersection { machine.triangle_writes() } else { spec.writes };
            let spec = KindSpec { writes, ..spec };
            issue_queues
                .of_kind(kind)
                .map(|unit| Unit::new(&spec, unit, issue_queues.core(unit), line))
                .collect::<Vec<_>>()
        };
        let dispatch = Dispatch::new(machine, header);
        let rays = dispatch.flights.len();
        Self {
            division: machine.division,
            place: machine.shadow_cache.place,
            cores: machine.cores.size(),
            divisions: vec![Division::default(); machine.cores.size() * machine.division.count.size()],
            layout: Layout::new(header, machine),
            dispatch,
            rays: vec![Whereabouts::IDLE; rays],
            units: Kind::ALL.into_iter().flat_map(of_kind).collect(),
            issue_queues,
            memory: Memory::new(machine, watch),
            port: Port::new(machine),
            agenda: Agenda::new(rays + 1),
            frames_over: [0; 2],
            shading: false,
        }
    }

    pub(super) fn await_shading(&mut self) {
        if !self.shading
            && let Some(at) = self.dispatch.next_shaded()
        {
            self.shading = true;
            self.agenda.put(at, self.rays.len() as u32);
        }
    }

    /// Hands out all that is possible in cycle `at`, and reads on in the stream.
    fn hand_out(&mut self, at: u64, feed: &mut dyn Feed) -> Result<(), RunError> {
        self.hand_out_all(at, feed)?;
        if feed.marks() {
            let tally = self.tally(at + 1);
            if let Some(warm) = feed.mark(&tally) {
                let l1s = Kind::ALL.into_iter().flat_map(|kind| warm.l1s(kind));
                self.units.iter_mut().zip(l1s).for_each(|(unit, l1)| unit.hold(l1.tags()));
                self.memory.hold(&warm.banks);
            }
        }
        Ok(())
    }

    fn hand_out_all(&mut self, at: u64, feed: &mut dyn Feed) -> Result<(), RunError> {
        while let Some(given) = self.dispatch.next(at, feed, &mut self.layout)? {
            self.tell_frame(at, feed)?;
            let (id, at, holder, stage) = match given {
                Given::Frame(info) => {
                    if let Some(port) = &mut self.port {
                        port.begin_frame(&info, &self.layout, at, &mut self.memory);
                        self.dispatch.heed(port);
                    }
                    let first = self.layout.dynamic_part();
                    self.units.iter_mut().for_each(|unit| unit.drop_from(first, at, &mut self.memory));
                    self.memory.drop_from(first, at);
                    continue;
                }
                Given::Traced(id, at) => (id, at, Holder::Traversal, Stage::Step),
                Given::Skipped(id, at) | Given::Ending(id, at) => (id, at, Holder::ShadowCache, Stage::Policy),
            };
            if let Some(port) = &mut self.port
                && !matches!(given, Given::Ending(..))
            {
                port.hand_over(self.dispatch.handed_over_at(), &mut self.memory);
                self.dispatch.heed(port);
            }
            let undecided = matches!(given, Given::Skipped(..)) && self.dispatch.units_decide();
            self.rays[id as usize] = Whereabouts { stage, holder, undecided, ..Whereabouts::IDLE };
            self.agenda.put(at, id);
        }
        self.tell_frame(at, feed)
    }

    /// Reports the counts up to cycle `at`, or until the host's port lets the frame end, if a frame is over.
    fn tell_frame(&mut self, at: u64, feed: &mut dyn Feed) -> Result<(), RunError> {
        if feed.wants_frame() {
            let at = at.max(self.dispatch.lets_end_at);
            self.frames_over = [self.frames_over[1], at + 1];
            feed.frame_counted(&self.tally(at + 1))?;
        }
        Ok(())
    }

    /// The receiver of accesses.
    pub(crate) fn into_watch(self) -> W {
        self.memory.watch
    }

    /// Lets all pending work end; returns the cycle of its end.
    fn settle(&mut self, now: u64) -> u64 {
        let units = self.units.iter().map(Unit::settled_at).max().unwrap_or(0);
        self.units.iter_mut().for_each(|unit| unit.settle(u64::MAX, &mut self.memory));
        let host = self.port.as_ref().map_or(0, Port::lets_end_at);
        let end = now.max(units).max(host).max(self.memory.settled_at());
        self.memory.settle(u64::MAX);
        end.max(self.memory.settled_at())
    }
}

impl<W: Watch> Engine for Profile<W> {
    fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError> {
        let shading_ends = self.rays.len() as u32;
        let mut last = 0;
        self.hand_out(0, feed)?;
        while let Some(now) = self.agenda.turn() {
            while let Some(id) = self.agenda.take() {
                if id == shading_ends {
                    self.shading = false;
                    self.dispatch.shaded(now);
                    self.await_shading();
                } else {
                    self.act(id, now);
                }
            }
            last = now;
            if std::mem::take(&mut self.dispatch.freed) {
                self.hand_out(now + 1, feed)?;
            }
        }
        if !self.dispatch.is_over() {
            let queues = format!("rays in flight {}", self.dispatch.in_flight());
            return Err(RunError::Deadlock { cycle: last, queues });
        }
        Ok((self.settle(last) + 1).max(self.frames_over[0]))
    }

    fn tally(&self, cycles: u64) -> Tally {
        let units = |kind| self.units[self.issue_queues.of_kind(kind)].iter().map(Unit::tally).collect();
        Tally {
            cycles,
            rays: self.dispatch.rays_done,
            dispatcher: busy(self.dispatch.busy),
            units: Kind::ALL.map(units),
            divisions: self.divisions.iter().map(|unit| busy(unit.begun * self.division.interval.get())).collect(),
            banks: self.memory.banks(),
            port: self.port.as_ref().map(|port| port.counts.clone()).unwrap_or_default(),
            channels: self.memory.channels(cycles),
            ..Tally::default()
        }
    }

    fn logs(&mut self) -> Vec<&mut ChannelLog> {
        Vec::new()
    }
}
