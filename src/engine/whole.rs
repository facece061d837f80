//! Replays a whole stream, within the laws that every run must keep.

use super::bound::{self, Bound};
use super::check;
use super::contract::Engine;
use super::error::RunError;
use super::feed::Feed;
use super::items::ItemStream;
use super::level::{Level, engine};
use super::observe::{self, DramObserver};
use super::source::{FrameCounts, StoreWork};
use super::tally::Tally;
use crate::machine::MachineSpec;
use crate::machine::shadow_cache::ShadowCacheSpec;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::{Header, Item};

/// Replays `items`, a stream with the given header, by `level`. Memory is bounded: a chunk is dropped when all its rays are done.
/// The run's identities (counts as the tracer's, conservation of bytes between levels, one cause for every cycle of every unit,
/// bounds) are checked, and a violation is an error.
///
/// # Errors
/// The level refuses the machine, or the run fails.
pub fn whole(
    level: Level,
    machine: &MachineSpec,
    header: &Header,
    items: &mut ItemStream<'_>,
    observer: Option<&mut dyn DramObserver>,
) -> Result<MachineStats, RunError> {
    let Some(mut engine) = engine(level, machine, header)? else { return bound::run(machine, header, items) };
    let stats = within_bounds(engine.as_mut(), machine, header, items, observer)?;
    Ok(match level {
        Level::Profile => MachineStats { accuracy: Accuracy::Bounded, ..stats },
        Level::Bound | Level::Event | Level::Cycle => stats,
    })
}

/// Replays everything by `engine`, within the bounds of every machine.
///
/// # Errors
/// The run fails, or leaves the bounds.
pub fn within_bounds(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    header: &Header,
    items: &mut ItemStream<'_>,
    observer: Option<&mut dyn DramObserver>,
) -> Result<MachineStats, RunError> {
    let mut bound = Bound::new(machine, header, false);
    let mut counted = items.inspect(|item| item.iter().for_each(|item| bound.add(item)));
    let tally = replay(engine, machine, &mut counted, observer)?;
    drop(counted);
    let (stats, bounds) = (tally.stats(machine), bound.bounds());
    check::bounds(&stats, &bounds).map_err(RunError::Invariant)?;
    Ok(MachineStats { bounds: Some(bounds), ..stats })
}

/// Replays everything by `engine`; what was counted, whose identities hold.
///
/// # Errors
/// The run fails, or violates an identity.
pub fn replay(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    items: &mut ItemStream<'_>,
    observer: Option<&mut dyn DramObserver>,
) -> Result<Tally, RunError> {
    let mut feed = Whole::new(items, &machine.shadow_cache);
    let cycles = match observer {
        None => engine.run(&mut feed)?,
        Some(observer) => observe::run(engine, machine, &mut feed, observer)?,
    };
    let tally = Tally { stores: feed.stores, ..engine.tally(cycles) };
    check::run(&tally, machine).map_err(RunError::Invariant)?;
    Ok(tally)
}

/// Feeds an engine with all items.
pub struct Whole<'a> {
    items: &'a mut ItemStream<'a>,
    spec: &'a ShadowCacheSpec,
    /// What was done with stores otherwise than recorded.
    stores: StoreWork,
}

impl<'a> Whole<'a> {
    /// Feeds `items` to a machine with these shadow-cache units.
    pub fn new(items: &'a mut ItemStream<'_>, spec: &'a ShadowCacheSpec) -> Self {
        Self { items, spec, stores: StoreWork::default() }
    }
}

impl Feed for Whole<'_> {
    fn next(&mut self) -> Result<Option<Item>, RunError> {
        Ok(self.items.next().transpose()?)
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError> {
        self.stores += counts.stores;
        check::frame(counts, self.spec)
    }
}
