//! Replays a whole stream, and checks the identities that every run must keep.

use super::bound::{self, Bound};
use super::check;
use super::contract::Engine;
use super::error::RunError;
use super::feed::Feed;
use super::frame_log::FrameLog;
use super::items::ItemStream;
use super::level::{Level, engine};
use super::observe::{self, Observer};
use super::source::{FrameCounts, StoreWork};
use super::tally::Tally;
use crate::machine::MachineSpec;
use crate::stats::{Accuracy, MachineStats};
use crate::stream::{Header, Item};

/// Replays `items`, a stream with the given header, at `level`. Memory is bounded: a chunk is dropped when all its
/// rays are done. The run's identities are checked, and a violation is an error: counts equal the tracer's, bytes are
/// conserved between memory levels, every cycle of every unit has one cause, and the bounds hold.
///
/// # Errors
/// The level refuses the machine, or the run fails.
pub(crate) fn whole(
    level: Level,
    machine: &MachineSpec,
    header: &Header,
    items: &mut ItemStream<'_>,
    observer: Option<&mut dyn Observer>,
) -> Result<MachineStats, RunError> {
    let Some(mut engine) = engine(level, machine, header) else { return bound::run(machine, header, items) };
    let stats = within_bounds(engine.as_mut(), machine, header, items, observer)?;
    Ok(match level {
        Level::Profile => MachineStats { accuracy: Accuracy::Bounded, ..stats },
        Level::Bound | Level::Event | Level::Cycle => stats,
    })
}

/// Replays all items by `engine`, and checks the bounds that hold for every machine.
///
/// # Errors
/// The run fails, or violates the bounds.
pub(crate) fn within_bounds(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    header: &Header,
    items: &mut ItemStream<'_>,
    observer: Option<&mut dyn Observer>,
) -> Result<MachineStats, RunError> {
    let mut bound = Bound::new(machine, header, false);
    let mut counted = items.inspect(|item| item.iter().for_each(|item| bound.add(item)));
    let mut feed = Whole::new(machine, &mut counted);
    let watch = observer.map(|observer| (header.frames.as_slice(), observer));
    let whole = fed(engine, machine, &mut feed, watch)?.stats(machine);
    let frames = feed.frames;
    drop(counted);
    check::bounds(&whole, &bound.bounds(&[])).map_err(RunError::Invariant)?;
    let measured = frames.finish(whole, header).map_err(RunError::Invariant)?;
    Ok(MachineStats { bounds: Some(bound.bounds(&header.warmup)), ..measured })
}

/// Replays all items of `feed` under an observer, given with the stream's frame numbers. Returns the counts, of which
/// the identities hold.
///
/// # Errors
/// The run fails, or violates an identity.
pub(super) fn fed(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    feed: &mut Whole<'_, '_>,
    watch: Option<(&[u32], &mut dyn Observer)>,
) -> Result<Tally, RunError> {
    let cycles = match watch {
        None => engine.run(feed)?,
        Some((frames, observer)) => observe::run(engine, machine, frames, feed, observer)?,
    };
    let tally = Tally { stores: feed.stores, ..engine.tally(cycles) };
    check::run(&tally, machine).map_err(RunError::Invariant)?;
    Ok(tally)
}

/// Replays `items`. Returns the counts, of which the identities hold.
#[cfg(test)]
pub(super) fn replay(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    items: &mut ItemStream<'_>,
    observer: Option<&mut dyn Observer>,
) -> Result<Tally, RunError> {
    fed(engine, machine, &mut Whole::new(machine, items), observer.map(|observer| (&[][..], observer)))
}

/// Feeds an engine with all items.
pub(super) struct Whole<'m, 'i> {
    items: &'i mut ItemStream<'i>,
    /// The counts frame by frame.
    frames: FrameLog<'m>,
    /// Store steps that were performed otherwise than recorded.
    stores: StoreWork,
}

impl<'m, 'i> Whole<'m, 'i> {
    /// Feeds `items` to a machine.
    pub(super) fn new(machine: &'m MachineSpec, items: &'i mut ItemStream<'_>) -> Self {
        Self { items, frames: FrameLog::new(machine), stores: StoreWork::default() }
    }
}

impl Feed for Whole<'_, '_> {
    fn next(&mut self) -> Result<Option<Item>, RunError> {
        Ok(self.items.next().transpose()?)
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError> {
        self.stores += counts.stores;
        self.frames.over(*counts);
        check::frame(counts, &self.frames.machine().shadow_cache)
    }

    fn wants_frame(&self) -> bool {
        self.frames.is_over()
    }

    fn frame_counted(&mut self, tally: &Tally) -> Result<(), RunError> {
        self.frames.add(tally);
        Ok(())
    }
}
