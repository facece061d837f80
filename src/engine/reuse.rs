//! Reuse distances: what caches of all sizes would miss, in one pass.

use super::error::RunError;
use super::items::Source;
use super::profile::{Curves, Heat, Profile};
use super::whole::within_bounds;
use super::work::entries_as_recorded;
use crate::machine::{MachineSpec, SpecError};
use crate::ranged::Share;
use crate::stats::{Accuracy, MachineStats, ReuseLevel};
use crate::stream::Header;

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
    if !entries_as_recorded(machine) {
        let what = "reuse distances are known only with `place: Own`, `register: 0`, `frame_end: List` and no \
                    `latched: Buffers` of `shadow_cache`";
        return Err(SpecError::new(what).into());
    }
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
