//! The engine: holds all parts, and lets the due parts act.

use super::super::contract::Engine;
use super::super::error::RunError;
use super::super::feed::{CycleEnd, Feed};
use super::super::part_set::{Members, PartSet, Range};
use super::super::snapshot::Snapshot;
use super::super::tally::{BankTally, ChannelTally, Tally, UnitTally};
use super::super::warm::WarmCaches;
use super::super::watchdog::patience;
use super::dispatcher::Dispatcher;
use super::division::Division;
use super::intersection::Intersection;
use super::links::Links;
use super::list::List;
use super::memory::Memory;
use super::pipeline::Pipeline;
use super::port::Port;
use super::shadow_cache::ShadowCache;
use super::traversal::Traversal;
use super::wheel::Wheel;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::parts::Parts;
use crate::memory::Wake;
use crate::memory::bank::Bank;
use crate::memory::dram::command::ChannelLog;
use crate::memory::queue::Queue;
use crate::stream::Header;

/// Lets the due parts of a kind act, beginning with number `now` modulo their count (round robin).
#[inline]
fn each_due(parts: Range, due: &PartSet, now: u64, mut tick: impl FnMut(usize)) {
    let Range { first, end, .. } = parts;
    let mut tick = |part: u32| tick((part - first) as usize);
    match due.within(parts) {
        Members::None => {}
        Members::One(part) => tick(part),
        Members::Several => {
            let middle = first + (now % u64::from(end - first)) as u32;
            due.each(middle, end, &mut tick);
            due.each(first, middle, &mut tick);
        }
    }
}

/// The parts that act after the dispatcher, kind by kind in the order in which the kinds act.
#[derive(Clone, Copy, Debug)]
struct Groups {
    traversal: Range,
    list: Range,
    intersection: Range,
    division: Range,
    shadow_cache: Range,
    banks: Range,
    channels: Range,
}

impl Groups {
    fn new(parts: &Parts) -> Self {
        let mut first = 1;
        let mut group = |count: u32| {
            first += count;
            Range::new(first - count, first)
        };
        Self {
            traversal: group(parts.traversal),
            list: group(parts.list),
            intersection: group(parts.intersection),
            division: group(parts.division),
            shadow_cache: group(parts.shadow_cache),
            banks: group(parts.banks),
            // After the host's port, if there is one.
            channels: Range::new(parts.channel(0).0, parts.channel(parts.channels).0),
        }
    }
}

/// The event-driven engine.
pub(in crate::engine) struct Event {
    pub(in crate::engine) dispatcher: Dispatcher,
    pub(in crate::engine) traversal: Vec<Traversal>,
    pub(in crate::engine) list: Vec<List>,
    pub(in crate::engine) intersection: Vec<Intersection>,
    pub(in crate::engine) division: Vec<Division>,
    pub(in crate::engine) shadow_cache: Vec<ShadowCache>,
    pub(in crate::engine) links: Links,
    groups: Groups,
    /// Progress at the watchdog's last check, the cycle of its next check, and its limit in cycles.
    progress: u64,
    watch_at: u64,
    patience: u64,
    /// Whether all parts are woken in all cycles: slow, and must change no result.
    #[cfg(test)]
    pub(in crate::engine) eager: bool,
}

impl Event {
    pub(in crate::engine) fn new(spec: &MachineSpec, header: &Header) -> Self {
        let memory = Memory::new(spec);
        let wheel = Wheel::new(Parts::new(spec).count());
        let links = Links::new(spec, header, wheel);
        let parts = links.parts;
        Self {
            dispatcher: Dispatcher::new(spec),
            traversal: (0..parts.traversal)
                .map(|index| Traversal::new(&spec.traversal, memory, index, &links))
                .collect(),
            list: (0..parts.list).map(|index| List::new(&spec.list, memory, index, &links)).collect(),
            intersection: (0..parts.intersection)
                .map(|index| Intersection::new(&spec.intersection, spec.triangle_writes(), memory, index, &links))
                .collect(),
            division: (0..parts.division).map(|index| Division::new(&spec.division, index, &links)).collect(),
            shadow_cache: (0..parts.shadow_cache)
                .map(|index| ShadowCache::new(&spec.shadow_cache, memory, spec.pool(), index, &links))
                .collect(),
            groups: Groups::new(&parts),
            links,
            progress: 0,
            watch_at: patience(spec),
            patience: patience(spec),
            #[cfg(test)]
            eager: false,
        }
    }

    /// The pipelines of the units that work on rays, kind by kind.
    fn pipelines(&self) -> [Vec<&Pipeline>; Kind::ALL.len()] {
        [
            self.traversal.iter().map(|unit| &unit.pipeline).collect(),
            self.list.iter().map(|unit| &unit.pipeline).collect(),
            self.intersection.iter().map(|unit| &unit.pipeline).collect(),
            self.shadow_cache.iter().map(|unit| &unit.pipeline).collect(),
        ]
    }

    fn pipelines_mut(&mut self) -> impl Iterator<Item = &mut Pipeline> {
        let Self { traversal, list, intersection, shadow_cache, .. } = self;
        let traversal = traversal.iter_mut().map(|unit| &mut unit.pipeline);
        let list = list.iter_mut().map(|unit| &mut unit.pipeline);
        let intersection = intersection.iter_mut().map(|unit| &mut unit.pipeline);
        let shadow_cache = shadow_cache.iter_mut().map(|unit| &mut unit.pipeline);
        traversal.chain(list).chain(intersection).chain(shadow_cache)
    }

    /// Lets all due parts but the dispatcher act.
    #[inline]
    fn tick_parts(&mut self, now: u64, due: &PartSet) {
        let Self { groups, traversal, list, intersection, division, shadow_cache, links, .. } = self;
        each_due(groups.traversal, due, now, |unit| traversal[unit].tick(now, links));
        each_due(groups.list, due, now, |unit| list[unit].tick(now, links));
        each_due(groups.intersection, due, now, |unit| intersection[unit].tick(now, links));
        each_due(groups.division, due, now, |unit| division[unit].tick(now, links));
        each_due(groups.shadow_cache, due, now, |unit| shadow_cache[unit].tick(now, links));
        each_due(groups.banks, due, now, |bank| links.tick_bank(bank, now));
        if links.port.is_some() && due.has(links.parts.port()) {
            links.tick_port(now);
        }
        each_due(groups.channels, due, now, |channel| links.tick_channel(channel, now));
    }

    fn drop_dynamic_lines(&mut self) {
        let first = self.links.layout.dynamic_part();
        self.pipelines_mut().for_each(|pipeline| pipeline.drop_from(first));
    }

    /// Loads the contents of the warm caches into all caches.
    fn hold(&mut self, warm: &WarmCaches) {
        let l1 = |kind: Kind, index: usize| warm.l1s(kind)[index].tags();
        self.traversal.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::Traversal, i)));
        self.list.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::List, i)));
        self.intersection.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::Intersection, i)));
        self.shadow_cache.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::ShadowCache, i)));
        self.links.l2.banks.iter_mut().zip(warm.banks.iter()).for_each(|(bank, cache)| bank.hold(cache.tags()));
    }

    fn is_idle(&self) -> bool {
        self.pipelines().into_iter().flatten().all(Pipeline::is_idle)
            && self.links.l2.banks.iter().all(|bank| bank.is_idle())
            && self.links.dram.is_idle()
    }

    fn watch(&mut self, now: u64) -> Result<(), RunError> {
        if now < self.watch_at {
            return Ok(());
        }
        // While a frame is built, nothing else need happen (rule H6).
        let built_at = self.links.port.as_ref().map_or(0, Port::built_at);
        if now < built_at + self.patience {
            self.watch_at = built_at + self.patience;
            return Ok(());
        }
        let units = self.pipelines().into_iter().flatten();
        let begun: u64 = units.map(|pipeline| pipeline.causes().busy()).sum();
        let dram = &self.links.dram;
        let columns: u64 = (0..dram.channels()).map(|i| dram.counts(i).reads + dram.counts(i).writes).sum();
        let divided: u64 = self.division.iter().map(|unit| unit.causes.busy()).sum();
        let progress = self.dispatcher.causes.busy() + begun + divided + columns;
        if progress == self.progress {
            return Err(RunError::Deadlock { cycle: now, queues: self.queues() });
        }
        (self.progress, self.watch_at) = (progress, now + self.patience);
        Ok(())
    }

    fn queues(&self) -> String {
        let links = &self.links;
        let mut lines = vec![format!("dispatcher: {}", self.dispatcher.queues())];
        let mut list = |name: &str, index: usize, queues: String| lines.push(format!("{name} {index}: {queues}"));
        self.traversal.iter().enumerate().for_each(|(i, unit)| list("traversal", i, unit.queues()));
        self.list.iter().enumerate().for_each(|(i, unit)| list("list", i, unit.queues(links)));
        self.intersection.iter().enumerate().for_each(|(i, unit)| list("intersection", i, unit.queues(links)));
        self.division.iter().enumerate().for_each(|(i, unit)| list("division", i, unit.queues(links)));
        self.shadow_cache.iter().enumerate().for_each(|(i, unit)| list("shadow_cache", i, unit.queues(links)));
        links.l2.banks.iter().enumerate().for_each(|(i, bank)| list("l2 bank", i, bank.queues()));
        links.port.iter().for_each(|port| list("host port", 0, port.queues()));
        (0..links.dram.channels()).for_each(|i| list("dram channel", i, links.dram.queues(i)));
        lines.join("\n")
    }
}

impl Engine for Event {
    fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError> {
        let (hears, looks) = (feed.hears(), feed.looks());
        let mut due = PartSet::new(self.links.parts.count());
        // A feed asks for a mark only after the dispatcher has acted.
        let mut asks = false;
        if looks {
            self.links.looked_at = feed.look_at();
        }
        self.links.clock.wake(Parts::DISPATCHER, 0);
        (0..self.links.parts.channels).for_each(|index| self.links.clock.wake(self.links.parts.channel(index), 0));
        while let Some(now) = self.links.clock.turn(&mut due) {
            #[cfg(test)]
            if self.eager {
                (0..self.links.parts.count() as u32).for_each(|part| due.add(part));
                self.links.clock.wake(Parts::DISPATCHER, now + 1);
            }
            let is_looked_at = looks && feed.look_at() == now;
            if is_looked_at {
                (0..self.links.parts.count() as u32).for_each(|part| due.add(part));
            }
            let dispatches = due.has(Parts::DISPATCHER);
            if dispatches {
                let events = self.dispatcher.tick(now, &mut || feed.next(), &mut self.links)?;
                feed.rays_over(events.rays_over);
                if let Some(counts) = events.frame_over {
                    feed.frame_over(&counts)?;
                }
                if events.frame_began {
                    self.drop_dynamic_lines();
                }
            }
            asks = (dispatches || asks) && feed.marks();
            if asks {
                let tally = self.tally(now + 1);
                if let Some(warm) = feed.mark(&tally) {
                    debug_assert_eq!(now, 0, "caches are loaded before a unit works ahead");
                    self.hold(warm);
                }
            }
            self.tick_parts(now, &due);
            if hears {
                feed.heard(&mut self.logs())?;
            }
            if is_looked_at {
                let (snapshot, tally) = (|| self.snapshot(now + 1), || self.tally(now + 1));
                feed.looked(now, CycleEnd { snapshot: &snapshot, tally: &tally })?;
            }
            if dispatches && feed.wants_frame() {
                feed.frame_counted(&self.tally(now + 1))?;
                self.dispatcher.latencies.forget_longest();
            }
            if self.dispatcher.is_finished() && self.is_idle() {
                return Ok(now + 1);
            }
            if looks {
                self.links.looked_at = feed.look_at();
                if self.links.looked_at != u64::MAX {
                    self.links.clock.wake(Parts::DISPATCHER, self.links.looked_at);
                }
            }
            self.watch(now)?;
        }
        Err(RunError::Deadlock { cycle: self.links.clock.now(), queues: self.queues() })
    }

    fn tally(&self, cycles: u64) -> Tally {
        let unit = |unit: &Pipeline| UnitTally {
            causes: unit.causes().until(cycles),
            operations: unit.operations(cycles),
            cache: *unit.cache().counts(),
            l1: *unit.l1_counts(),
            requested: *unit.requested(),
            written_through: *unit.written_through(),
            bypassed: *unit.bypassed(),
            attributed: *unit.attributed(),
        };
        let Links { l2, dram, .. } = &self.links;
        let channel = |index| ChannelTally {
            counts: *dram.counts(index),
            moved: *dram.moved(index),
            refresh_due: dram.refresh_is_due(index, cycles - 1),
        };
        let banks =
            l2.banks.iter().map(|bank| BankTally { cache: *bank.cache().counts(), served: bank.served().clone() });
        Tally {
            cycles,
            has_causes: true,
            rays: self.dispatcher.rays(),
            dispatcher: self.dispatcher.causes.until(cycles),
            stores: Default::default(),
            units: self.pipelines().map(|units| units.into_iter().map(unit).collect()),
            queues: [
                vec![self.dispatcher.load()],
                vec![self.links.done.load()],
                self.links.lists.iter().map(Queue::load).collect(),
                self.links.tests.iter().map(Queue::load).collect(),
                self.links.divisions.iter().map(Queue::load).collect(),
                l2.banks.iter().map(Bank::load).collect(),
                (0..dram.channels()).map(|index| dram.load(index)).collect(),
            ],
            latencies: self.dispatcher.latencies,
            divisions: self.division.iter().map(|unit| unit.causes.until(cycles)).collect(),
            banks: banks.collect(),
            port: self.links.port.as_ref().map(|port| port.counts().clone()).unwrap_or_default(),
            channels: (0..dram.channels()).map(channel).collect(),
        }
    }

    fn snapshot(&self, cycles: u64) -> Snapshot {
        let Links { l2, dram, .. } = &self.links;
        let pipelines = self.pipelines();
        let units = || pipelines.iter().flatten();
        let dispatcher = std::iter::once(&self.dispatcher.causes);
        let causes =
            dispatcher.chain(units().map(|unit| unit.causes())).chain(self.division.iter().map(|unit| &unit.causes));
        let queues = [self.dispatcher.waiting(), self.links.done.len()]
            .into_iter()
            .chain(self.links.lists.iter().map(Queue::len))
            .chain(self.links.tests.iter().map(Queue::len))
            .chain(self.links.divisions.iter().map(Queue::len))
            .chain(l2.banks.iter().map(Bank::waiting))
            .chain((0..dram.channels()).map(|index| dram.waiting(index)));
        let caches = units().map(|unit| unit.cache()).chain(l2.banks.iter().map(Bank::cache));
        Snapshot {
            causes: causes.map(|causes| causes.until(cycles)).collect(),
            queues: queues.map(|entries| entries as u32).collect(),
            misses: caches.map(|cache| cache.misses_under_way() as u32).collect(),
        }
    }

    fn logs(&mut self) -> Vec<&mut ChannelLog> {
        self.links.dram.logs()
    }
}
