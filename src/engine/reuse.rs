//! Reuse distances: the misses of caches of all sizes, in one pass.

use super::error::RunError;
use super::items::Source;
use super::profile::{Curves, Heat, Profile};
use super::whole::within_bounds;
use super::work::entries_as_recorded;
use crate::machine::{MachineSpec, SpecError};
use crate::ranged::Share;
use crate::stats::{Accuracy, MachineStats, ReuseLevel};
use crate::stream::{Header, Item, StreamError};

/// The lines whose reuse is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReuseOf {
    /// All lines.
    Everything,
    /// A share of the lines, chosen by a hash, and the hottest lines.
    Sample {
        /// The share of the lines.
        rate: Share,
        /// Number of hottest lines, which are in the sample whatever their hash.
        hot: usize,
    },
}

/// Replays a stream as [`super::Level::Profile`] does, and measures reuse distances. Returns the machine's counts, and
/// the misses of caches of all sizes. For a sample, the stream is read once more, to find the hottest lines.
///
/// # Errors
/// The machine does not access stores as recorded, or the run fails.
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

/// Number of rays of a frame from which the hottest lines are found.
const LEARNED_FROM: usize = 1 << 15;
/// Number of hottest lines, and the share of the other lines that is measured: `ladder-map` reports their accuracy.
const HOT: usize = 256;
const SHARE: f64 = 0.05;

/// Measures the reuse distances of a sample of the lines in one frame, `items`, as if the frame were repeated: the
/// misses of caches that have seen the frame before.
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

/// Refuses machines that do not access stores as recorded.
fn check(machine: &MachineSpec) -> Result<(), SpecError> {
    let what = "reuse distances are known only with `place: Own`, `register: 0`, `frame_end: List` and no `latched: \
                Buffers` of `shadow_cache`";
    if entries_as_recorded(machine) { Ok(()) } else { Err(SpecError::new(what)) }
}
