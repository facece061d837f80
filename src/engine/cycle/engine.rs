//! The machine and its cycle loop.

use super::dispatcher::Dispatcher;
use super::division::Division;
use super::dram::Channel;
use super::intersection::Intersection;
use super::l2::Bank;
use super::link::Link;
use super::list::List;
use super::shadow_cache::ShadowCache;
use super::traversal::Traversal;
use super::unit::Unit;
use super::wires::Wires;
use crate::engine::contract::Engine;
use crate::engine::error::RunError;
use crate::engine::feed::{CycleEnd, Feed};
use crate::engine::snapshot::Snapshot;
use crate::engine::tally::{BankTally, ChannelTally, Tally};
use crate::engine::watchdog::patience;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::memory::bank::Served;
use crate::memory::dram::command::ChannelLog;
use crate::stream::Header;

/// The machine.
pub(crate) struct Cycle {
    dispatcher: Dispatcher,
    traversal: Vec<Traversal>,
    list: Vec<List>,
    intersection: Vec<Intersection>,
    division: Vec<Division>,
    shadow_cache: Vec<ShadowCache>,
    banks: Vec<Bank>,
    channels: Vec<Channel>,
    wires: Wires,
    patience: u64,
}

/// The numbers below `count` in the order in which parts act in cycle `now`: the first part rotates.
fn in_turn(count: usize, now: u64) -> impl Iterator<Item = usize> {
    let first = (now % count as u64) as usize;
    (0..count).map(move |step| (first + step) % count)
}

impl Cycle {
    pub(crate) fn new(spec: &MachineSpec, header: &Header) -> Self {
        let cores = spec.cores.size();
        let (units, lists) = (cores * spec.traversal.count.size(), cores * spec.list.count.size());
        let tests = cores * spec.intersection.count.size();
        let (pool, line) = (spec.pool() as usize, spec.line_bytes.get());
        let channel = |index| Channel::new(&spec.dram, index, spec.clock_mhz.get(), line);
        let mut banks = Vec::new();
        for (_, cache) in (0..cores).flat_map(|_| spec.l2.caches()) {
            for _ in 0..cache.banks.get() {
                banks.push(Bank::new(cache, &spec.dram, banks.len(), line));
            }
        }
        Self {
            dispatcher: Dispatcher::new(spec),
            traversal: (0..units).map(|index| Traversal::new(&spec.traversal, index, line)).collect(),
            list: (0..lists).map(|index| List::new(&spec.list, index, units + index, line)).collect(),
            intersection: (0..tests)
                .map(|index| (index, units + lists + index))
                .map(|(index, l1)| Intersection::new(&spec.intersection, spec.triangle_writes(), index, l1, line))
                .collect(),
            division: (0..cores * spec.division.count.size())
                .map(|index| Division::new(&spec.division, index))
                .collect(),
            shadow_cache: (0..cores * spec.shadow_cache.count.size())
                .map(|index| (index, units + lists + tests + index))
                .map(|(index, l1)| ShadowCache::new(&spec.shadow_cache, index, pool, l1, line))
                .collect(),
            banks,
            channels: (0..spec.dram.channels.size()).map(channel).collect(),
            wires: Wires::new(spec, header),
            patience: patience(spec),
        }
    }

    fn tick_units(&mut self, now: u64) {
        let wires = &mut self.wires;
        in_turn(self.traversal.len(), now).for_each(|index| self.traversal[index].tick(now, wires));
        in_turn(self.list.len(), now).for_each(|index| self.list[index].tick(now, wires));
        in_turn(self.intersection.len(), now).for_each(|index| self.intersection[index].tick(now, wires));
        in_turn(self.division.len(), now).for_each(|index| self.division[index].tick(now, wires));
        in_turn(self.shadow_cache.len(), now).for_each(|index| self.shadow_cache[index].tick(now, wires));
        in_turn(self.banks.len(), now).for_each(|index| self.banks[index].tick(now, wires));
        wires.tick_port(now);
        in_turn(self.channels.len(), now).for_each(|index| self.channels[index].tick(now, wires));
        wires.settle();
    }

    fn drop_dynamic_lines(&mut self) {
        let first = self.wires.layout.dynamic_part();
        self.traversal.iter_mut().for_each(|unit| unit.unit.drop_from(first));
        self.list.iter_mut().for_each(|unit| unit.unit.drop_from(first));
        self.intersection.iter_mut().for_each(|unit| unit.unit.drop_from(first));
        self.shadow_cache.iter_mut().for_each(|unit| unit.unit.drop_from(first));
        self.banks.iter_mut().for_each(|bank| bank.drop_from(first));
    }

    fn units(&self) -> [Vec<&Unit>; Kind::ALL.len()] {
        [
            self.traversal.iter().map(|unit| &unit.unit).collect(),
            self.list.iter().map(|unit| &unit.unit).collect(),
            self.intersection.iter().map(|unit| &unit.unit).collect(),
            self.shadow_cache.iter().map(|unit| &unit.unit).collect(),
        ]
    }

    fn memory_is_empty(&self) -> bool {
        self.units().into_iter().flatten().all(Unit::memory_is_empty)
            && self.banks.iter().all(Bank::is_empty)
            && self.channels.iter().all(Channel::is_empty)
            && self.wires.memory_is_empty()
    }

    fn queues(&self) -> String {
        let wires = &self.wires;
        let mut lines = vec![format!("dispatcher: {}", self.dispatcher.queues(wires))];
        let mut list = |name: &str, index: usize, queues: String| lines.push(format!("{name} {index}: {queues}"));
        self.traversal.iter().enumerate().for_each(|(i, unit)| list("traversal", i, unit.queues()));
        self.list.iter().enumerate().for_each(|(i, unit)| list("list", i, unit.queues(wires)));
        self.intersection.iter().enumerate().for_each(|(i, unit)| list("intersection", i, unit.queues(wires)));
        self.division.iter().enumerate().for_each(|(i, unit)| list("division", i, unit.queues(wires)));
        self.shadow_cache.iter().enumerate().for_each(|(i, unit)| list("shadow_cache", i, unit.queues(wires)));
        self.banks.iter().enumerate().for_each(|(i, bank)| list("l2 bank", i, bank.queues(wires)));
        wires.port.iter().for_each(|port| list("host port", 0, port.queues()));
        self.channels.iter().enumerate().for_each(|(i, channel)| list("dram channel", i, channel.queues(wires)));
        lines.join("\n")
    }
}

impl Engine for Cycle {
    fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError> {
        let (hears, looks) = (feed.hears(), feed.looks());
        let (mut progress, mut watched) = (0, 0);
        for now in 0.. {
            let cycle = self.dispatcher.tick(now, &mut || feed.next(), &mut self.wires)?;
            if let Some(counts) = cycle.frame_over {
                feed.frame_over(&counts)?;
            }
            if cycle.frame_began {
                self.drop_dynamic_lines();
            }
            self.tick_units(now);
            if hears {
                feed.heard(&mut self.logs())?;
            }
            if looks && feed.look_at() == now {
                let (snapshot, tally) = (|| self.snapshot(now + 1), || self.tally(now + 1));
                feed.looked(now, CycleEnd { snapshot: &snapshot, tally: &tally })?;
            }
            if feed.wants_frame() {
                feed.frame_counted(&self.tally(now + 1))?;
                self.dispatcher.latencies.forget_longest();
            }
            if self.dispatcher.is_finished() && self.memory_is_empty() {
                return Ok(now + 1);
            }
            let is_built = self.wires.port.as_ref().is_none_or(|port| port.is_built(now));
            if !is_built {
                watched = now;
            }
            if now - watched == self.patience {
                let progress_now = self.tally(now + 1).operations();
                if progress_now == progress {
                    return Err(RunError::Deadlock { cycle: now, queues: self.queues() });
                }
                (progress, watched) = (progress_now, now);
            }
        }
        unreachable!("the cycles do not end")
    }

    fn tally(&self, cycles: u64) -> Tally {
        let bank = |bank: &Bank| BankTally {
            cache: *bank.counts(),
            served: Served { moved: bank.moved, reads: bank.reads, missed: bank.missed, ..Served::default() },
        };
        let channel = |channel: &Channel| ChannelTally {
            counts: channel.counts,
            moved: channel.moved,
            refresh_due: channel.refresh_is_due(),
        };
        Tally {
            cycles,
            has_causes: true,
            rays: self.dispatcher.rays,
            dispatcher: self.dispatcher.causes,
            stores: Default::default(),
            units: self.units().map(|units| units.into_iter().map(Unit::tally).collect()),
            queues: [
                vec![self.wires.in_fifo.load()],
                vec![self.wires.out_fifo.load()],
                self.wires.lists.iter().map(Link::load).collect(),
                self.wires.tests.iter().map(Link::load).collect(),
                self.wires.divisions.iter().map(Link::load).collect(),
                self.wires.to_bank.iter().map(Link::load).collect(),
                self.wires.to_channel.iter().map(Link::load).collect(),
            ],
            latencies: self.dispatcher.latencies,
            divisions: self.division.iter().map(|unit| unit.causes).collect(),
            banks: self.banks.iter().map(bank).collect(),
            port: self.wires.port.as_ref().map(|port| port.counts.clone()).unwrap_or_default(),
            channels: self.channels.iter().map(channel).collect(),
        }
    }

    fn snapshot(&self, _: u64) -> Snapshot {
        let units = self.units();
        let of_units = units.iter().flatten().map(|unit| unit.tally.causes);
        let dispatcher = std::iter::once(self.dispatcher.causes);
        let Wires { in_fifo, out_fifo, lists, tests, divisions, to_bank, to_channel, .. } = &self.wires;
        let queues = [in_fifo.len(), out_fifo.len()]
            .into_iter()
            .chain(lists.iter().map(Link::len))
            .chain(tests.iter().map(Link::len))
            .chain(divisions.iter().map(Link::len))
            .chain(to_bank.iter().map(Link::len))
            .chain(to_channel.iter().map(Link::len));
        let misses = units.iter().flatten().map(|unit| unit.misses_under_way());
        Snapshot {
            causes: dispatcher.chain(of_units).chain(self.division.iter().map(|unit| unit.causes)).collect(),
            queues: queues.map(|entries| entries as u32).collect(),
            misses: misses.chain(self.banks.iter().map(Bank::misses_under_way)).map(|misses| misses as u32).collect(),
        }
    }

    fn logs(&mut self) -> Vec<&mut ChannelLog> {
        self.channels.iter_mut().filter_map(Channel::log).collect()
    }
}
