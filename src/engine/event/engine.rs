//! The engine itself: the machine in motion, and whose turn it is.

use super::super::contract::Engine;
use super::super::error::RunError;
use super::super::feed::Feed;
use super::super::part_set::PartSet;
use super::super::tally::{BankTally, ChannelTally, Tally, UnitTally};
use super::super::warm::WarmCaches;
use super::super::watchdog::patience;
use super::dispatcher::Dispatcher;
use super::division::Division;
use super::intersection::Intersection;
use super::links::Links;
use super::list::List;
use super::pipeline::Pipeline;
use super::shadow_cache::ShadowCache;
use super::traversal::Traversal;
use super::wheel::Wheel;
use crate::machine::MachineSpec;
use crate::machine::kinds::Kind;
use crate::machine::parts::Parts;
use crate::memory::bank::Bank;
use crate::memory::dram::command::ChannelLog;
use crate::memory::queue::Queue;
use crate::memory::{PartId, Wake};
use crate::stream::Header;

/// The machine in motion.
pub(in crate::engine) struct Event {
    pub(in crate::engine) dispatcher: Dispatcher,
    pub(in crate::engine) traversal: Vec<Traversal>,
    pub(in crate::engine) list: Vec<List>,
    pub(in crate::engine) intersection: Vec<Intersection>,
    pub(in crate::engine) division: Vec<Division>,
    pub(in crate::engine) shadow_cache: Vec<ShadowCache>,
    pub(in crate::engine) links: Links<Wheel>,
    /// Operations begun when the watchdog last looked, when it looks again, and how long it waits.
    progress: u64,
    watch_at: u64,
    patience: u64,
    /// Wakes all parts in all cycles: slow, and must change nothing.
    #[cfg(test)]
    pub(in crate::engine) eager: bool,
}

impl Event {
    pub(in crate::engine) fn new(spec: &MachineSpec, header: &Header) -> Self {
        let line = spec.line_bytes.get();
        let wheel = Wheel::new(Parts::new(spec).count());
        let links = Links::new(spec, header, wheel);
        let parts = links.parts;
        Self {
            dispatcher: Dispatcher::new(spec),
            traversal: (0..parts.traversal).map(|index| Traversal::new(&spec.traversal, line, index, &links)).collect(),
            list: (0..parts.list).map(|index| List::new(&spec.list, line, index, &links)).collect(),
            intersection: (0..parts.intersection)
                .map(|index| Intersection::new(&spec.intersection, spec.triangle_writes(), line, index, &links))
                .collect(),
            division: (0..parts.division).map(|index| Division::new(&spec.division, index, &links)).collect(),
            shadow_cache: (0..parts.shadow_cache)
                .map(|index| ShadowCache::new(&spec.shadow_cache, line, spec.pool(), index, &links))
                .collect(),
            links,
            progress: 0,
            watch_at: patience(spec),
            patience: patience(spec),
            #[cfg(test)]
            eager: false,
        }
    }

    /// The common parts of the units that work on rays, kind by kind.
    fn pipelines(&self) -> [Vec<&Pipeline>; Kind::ALL.len()] {
        [
            self.traversal.iter().map(|unit| &unit.pipeline).collect(),
            self.list.iter().map(|unit| &unit.pipeline).collect(),
            self.intersection.iter().map(|unit| &unit.pipeline).collect(),
            self.shadow_cache.iter().map(|unit| &unit.pipeline).collect(),
        ]
    }

    fn tick_units(&mut self, now: u64, due: &PartSet) {
        let Self { traversal, list, intersection, division, shadow_cache, links, .. } = self;
        let parts = links.parts;
        in_turn(due, parts.traversal(0), parts.traversal, now, |index| traversal[index].tick(now, links));
        in_turn(due, parts.list(0), parts.list, now, |index| list[index].tick(now, links));
        in_turn(due, parts.intersection(0), parts.intersection, now, |index| intersection[index].tick(now, links));
        in_turn(due, parts.division(0), parts.division, now, |index| division[index].tick(now, links));
        in_turn(due, parts.shadow_cache(0), parts.shadow_cache, now, |index| shadow_cache[index].tick(now, links));
        in_turn(due, parts.bank(0), parts.banks, now, |index| links.tick_bank(index, now));
        in_turn(due, parts.channel(0), parts.channels, now, |index| links.tick_channel(index, now));
    }

    fn drop_dynamic_lines(&mut self) {
        let first = self.links.layout.dynamic_part();
        self.traversal.iter_mut().for_each(|unit| unit.pipeline.drop_from(first));
        self.list.iter_mut().for_each(|unit| unit.pipeline.drop_from(first));
        self.intersection.iter_mut().for_each(|unit| unit.pipeline.drop_from(first));
        self.shadow_cache.iter_mut().for_each(|unit| unit.pipeline.drop_from(first));
    }

    /// All caches hold from now on what the warm ones do.
    fn hold(&mut self, warm: &WarmCaches) {
        let l1 = |kind: Kind, index: usize| &warm.l1s(kind)[index];
        self.traversal.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::Traversal, i)));
        self.list.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::List, i)));
        self.intersection.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::Intersection, i)));
        self.shadow_cache.iter_mut().enumerate().for_each(|(i, unit)| unit.pipeline.hold(l1(Kind::ShadowCache, i)));
        self.links.l2.banks.iter_mut().zip(warm.banks()).for_each(|(bank, cache)| bank.hold(cache));
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
        (0..links.dram.channels()).for_each(|i| list("dram channel", i, links.dram.queues(i)));
        lines.join("\n")
    }
}

impl Engine for Event {
    fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError> {
        let hears = feed.hears();
        let mut due = PartSet::default();
        self.links.clock.wake(Parts::DISPATCHER, 0);
        (0..self.links.parts.channels).for_each(|index| self.links.clock.wake(self.links.parts.channel(index), 0));
        while let Some(now) = self.links.clock.turn(&mut due) {
            #[cfg(test)]
            if self.eager {
                (0..self.links.parts.count() as u32).for_each(|part| due.add(part));
                self.links.clock.wake(Parts::DISPATCHER, now + 1);
            }
            if due.next(0, 1).is_some() {
                let events = self.dispatcher.tick(now, &mut || feed.next(), &mut self.links)?;
                feed.rays_over(events.rays_over);
                if let Some(counts) = events.frame_over {
                    feed.frame_over(&counts)?;
                }
                if events.frame_began {
                    self.drop_dynamic_lines();
                }
            }
            if feed.marks() {
                let tally = self.tally(now + 1);
                if let Some(warm) = feed.mark(&tally) {
                    self.hold(warm);
                }
            }
            self.tick_units(now, &due);
            if hears {
                feed.heard(&mut self.logs())?;
            }
            if self.dispatcher.is_finished() && self.is_idle() {
                return Ok(now + 1);
            }
            self.watch(now)?;
        }
        Err(RunError::Deadlock { cycle: self.links.clock.now(), queues: self.queues() })
    }

    fn tally(&self, cycles: u64) -> Tally {
        let unit = |unit: &Pipeline| UnitTally {
            causes: unit.causes().until(cycles),
            cache: *unit.cache().counts(),
            requested: *unit.requested(),
            written_through: *unit.written_through(),
            read_straight: *unit.read_straight(),
            marked: *unit.marked(),
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
            channels: (0..dram.channels()).map(channel).collect(),
        }
    }

    fn logs(&mut self) -> Vec<&mut ChannelLog> {
        self.links.dram.logs()
    }
}

/// Lets the due ones of `count` parts act, whose numbers begin with `first`: in cycle `now`, number `now mod count` first.
fn in_turn(due: &PartSet, PartId(first): PartId, count: u32, now: u64, mut act: impl FnMut(usize)) {
    let middle = first + (now % u64::from(count)) as u32;
    for (mut from, end) in [(middle, first + count), (first, middle)] {
        while let Some(part) = due.next(from, end) {
            act((part - first) as usize);
            from = part + 1;
        }
    }
}
