//! Sweeps: the same ray streams on many machines that differ in named fields of their specs.
//!
//! Frames are traced once; every point is a replay. Streams and points are kept in files named by hashes of their
//! inputs, so that a stopped sweep continues and ends with the same bytes. Processes share the work without
//! communication: each reads the same files, computes the same plan, and makes its shard of the plan.

mod collect;
mod draw;
mod error;
mod kept;
mod listing;
mod log;
mod make;
mod places;
mod plan;
mod points;
mod replay;
mod shard;
mod spec;
mod streams;
mod summary;
mod together;
mod values;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

pub use self::error::SweepError;
pub(super) use self::kept::kept;
pub(crate) use self::listing::{Listed, Listing};
use self::log::Log;
pub(super) use self::places::Places;
pub(super) use self::plan::{Plan, Point};
pub(super) use self::points::Key;
pub(super) use self::replay::{estimates, replay};
pub(crate) use self::shard::Shard;
pub(crate) use self::spec::ChosenLevel;
pub(super) use self::spec::Sweep;
pub(crate) use self::spec::SweepSpec;
pub(super) use self::streams::{Recorded, Streams};
pub(super) use self::summary::read as read_point;
use crate::output::{ResultsFolder, SharedFolder};
use crate::report::sweep::SweepSummary;
use crate::ron_file;

/// Runs or continues the sweep of the file `path`; keeps its streams and points in `folder`.
///
/// # Errors
/// A file is wrong or cannot be written, a replay fails, or `stop` was set.
pub(crate) fn sweep(
    path: &Path,
    level: ChosenLevel,
    folder: &ResultsFolder,
    stop: &AtomicBool,
) -> Result<SweepSummary, SweepError> {
    let sweep = Sweep::load(path, level)?;
    folder.make()?;
    let places = Places::of(folder.path());
    let plan = make(&sweep, &places, Shard::WHOLE, stop)?;
    summary::summary(&sweep, &plan, &places.points)
}

/// Makes or continues a shard of the sweep of the file `path`. Returns the number of the shard's points.
///
/// # Errors
/// As [`sweep`].
pub(crate) fn shard(
    path: &Path,
    level: ChosenLevel,
    folder: &SharedFolder,
    shard: Shard,
    stop: &AtomicBool,
) -> Result<usize, SweepError> {
    let sweep = Sweep::load(path, level)?;
    let plan = make(&sweep, &Places::of(folder.path()), shard, stop)?;
    Ok(plan.share(shard).len())
}

/// Records the streams of the sweep of the file `path`, or checks that they are complete.
///
/// # Errors
/// As [`sweep`].
pub(crate) fn record(
    path: &Path,
    level: ChosenLevel,
    folder: &SharedFolder,
    stop: &AtomicBool,
) -> Result<(), SweepError> {
    let sweep = Sweep::load(path, level)?;
    let places = Places::of(folder.path());
    places.make()?;
    Streams::new(&sweep.experiment, &places.streams).have(|_| true, stop)?;
    Ok(())
}

/// Merges the points of `others`, folders of shards, into `folder`. For missing points, `command` gives the command
/// that makes a shard in a folder.
///
/// # Errors
/// As [`sweep`], or points are missing or of another build of the program.
pub(crate) fn collect(
    path: &Path,
    level: ChosenLevel,
    folder: &ResultsFolder,
    others: &[PathBuf],
    command: impl Fn(Shard, &Path) -> String,
) -> Result<SweepSummary, SweepError> {
    let sweep = Sweep::load(path, level)?;
    folder.make()?;
    let places = Places::of(folder.path());
    places.make()?;
    let plan = Plan::new(&sweep, &Streams::new(&sweep.experiment, &places.streams).identities)?;
    collect::collect(&plan, folder.path(), others, command)?;
    summary::summary(&sweep, &plan, &places.points)
}

/// Lists the points of the sweep of the file `path`.
///
/// # Errors
/// A file is wrong.
pub(crate) fn list(path: &Path, level: ChosenLevel) -> Result<Listing, SweepError> {
    let sweep = Sweep::load(path, level)?;
    let plan = Plan::new(&sweep, &Streams::new(&sweep.experiment, Path::new("")).identities)?;
    Listing::new(&sweep, &plan)
}

/// The number of replays that the sweep of the file `path` allows; `None` if its machines are not a space.
///
/// # Errors
/// The file is wrong.
pub(crate) fn budget(path: &Path) -> Result<Option<usize>, SweepError> {
    Ok(ron_file::read::<SweepSpec>(path)?.budget())
}

/// Reads the sweep of the file `path` and all files that it names. Returns how many machines the sweep has.
///
/// # Errors
/// A file is wrong.
pub fn machine_count(path: &Path) -> Result<usize, SweepError> {
    Ok(Sweep::load(path, ChosenLevel::default())?.len())
}

/// Makes the points of a shard that are not kept yet.
fn make(sweep: &Sweep, places: &Places, shard: Shard, stop: &AtomicBool) -> Result<Plan, SweepError> {
    places.make()?;
    let streams = Streams::new(&sweep.experiment, &places.streams);
    let plan = Plan::new(sweep, &streams.identities)?;
    let identity = plan.identity();
    if shard != Shard::WHOLE {
        places.note(&identity, shard)?;
    }
    let share = plan.share(shard);
    let subject = format!("sweep {} {identity}, shard {shard}", sweep.experiment.spec.name);
    let wanted = make::missing(&share, &places.points);
    let log = Log::new(subject, share.len(), &costs(&wanted));
    if !wanted.is_empty() {
        let streams = streams.have(|policy| wanted.iter().any(|point| point.policy == policy), stop)?;
        make::make(sweep, &streams, &wanted, &places.points, &log, stop)?;
    }
    log.finish();
    Ok(plan)
}

fn costs(points: &[Point]) -> Vec<u64> {
    points.iter().map(|point| point.cost).collect()
}

/// Makes the points of `points` that `folder` does not keep yet, from recorded streams. `subject` names them in a log.
///
/// # Errors
/// A replay fails, a point cannot be kept, or `stop` was set.
pub(super) fn make_points(
    sweep: &Sweep,
    streams: &[Recorded],
    points: &[Point],
    folder: &Path,
    subject: String,
    stop: &AtomicBool,
) -> Result<(), SweepError> {
    let wanted = make::missing(points, folder);
    let log = Log::new(subject, points.len(), &costs(&wanted));
    make::make(sweep, streams, &wanted, folder, &log, stop)?;
    log.finish();
    Ok(())
}
