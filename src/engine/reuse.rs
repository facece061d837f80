//! Reuse distances: what caches of all sizes would miss, in one pass.

use super::error::RunError;
use super::items::Source;
use super::profile::{Curves, Heat, Profile};
use super::whole::within_bounds;
use super::work::entries_as_recorded;
use crate::machine::{MachineSpec, SpecError};
use crate::ranged::Share;
use crate::stats::{Accuracy, MachineStats, ReuseLevel};
use crate::stream::{Header, Item, StreamError};

/// Whose reuse is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReuseOf {
    /// All lines'.
    Everything,
    /// That of a share by a hash, and of so many of the hottest.
    Sample {
        /// The share.
        rate: Share,
        /// Lines that are in the sample whatever their hash.
        hot: usize,
    },
}

/// Replays a stream as [`super::Level::Profile`] does and measures reuse distances on the way: what the machine
/// measured, and misses of caches of all sizes. A sample reads the stream once more, to find the hottest lines.
///
/// # Errors
/// The machine's stores are not accessed as recorded, or the run fails.
pub(crate) fn reuse(
    machine: &MachineSpec,
    of: ReuseOf,
    header: &Header,
    source: &dyn Source,
) -> Result<(MachineStats, Vec<ReuseLevel>), RunError> {
    check(machine)?;
    let sample = match of {
        ReuseOf::Everything => None,
        ReuseOf::Sample { rate, hot } => {
            let mut heat = Heat::new(machine, header);
            for item in source.open(0)? {
                heat.add(&item?);
            }
            Some((rate.get(), heat.hottest(hot)))
        }
    };
    let mut engine = Profile::watched(machine, header, Curves::new(machine, sample));
    let mut items = source.open(0)?;
    let stats = within_bounds(&mut engine, machine, header, &mut items, None)?;
    Ok((MachineStats { accuracy: Accuracy::Bounded, ..stats }, engine.into_watch().levels()))
}

/// Rays of a frame from which the hottest lines are learned.
const LEARNED_FROM: usize = 1 << 15;
/// How many lines are the hottest, and the share of the others that is measured: `ladder-map` says how good that is.
const HOT: usize = 256;
const SHARE: f64 = 0.05;

/// Measures reuse distances of a sample of the lines in one frame, `items`, as if the frame came again and again: what
/// caches miss that have seen the frame before.
///
/// # Errors
/// See [`reuse`].
pub(crate) fn reuse_of_frame(
    machine: &MachineSpec,
    header: &Header,
    items: &mut dyn Iterator<Item = Result<Item, StreamError>>,
) -> Result<Vec<ReuseLevel>, RunError> {
    check(machine)?;
    let (mut heat, mut first, mut rays) = (Heat::new(machine, header), Vec::new(), 0);
    while rays < LEARNED_FROM
        && let Some(item) = items.next().transpose()?
    {
        heat.add(&item);
        if let Item::Rays(chunk) = &item {
            rays += chunk.len();
        }
        first.push(item);
    }
    let curves = Curves::new(machine, Some((SHARE, heat.hottest(HOT))));
    let mut engine = Profile::watched(machine, header, curves);
    within_bounds(&mut engine, machine, header, &mut first.into_iter().map(Ok).chain(items), None)?;
    let mut curves = engine.into_watch();
    curves.repeat();
    Ok(curves.levels())
}

/// Refuses machines whose stores are not accessed as recorded.
fn check(machine: &MachineSpec) -> Result<(), SpecError> {
    let what = "reuse distances are known only with `place: Own`, `register: 0`, `frame_end: List` and no `latched: \
                Buffers` of `shadow_cache`";
    if entries_as_recorded(machine) { Ok(()) } else { Err(SpecError::new(what)) }
}
