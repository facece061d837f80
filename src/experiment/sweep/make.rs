//! Makes points: those of a share that are not kept yet, several at a time, each by one process.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rayon::prelude::*;

use super::error::SweepError;
use super::log::Log;
use super::plan::Point;
use super::points::{self, Measured, Refused};
use super::replay::replay;
use super::spec::Sweep;
use super::streams::Recorded;
use crate::output::Turn;

/// How long a process waits for a point that another one makes before it looks again.
const PAUSE: Duration = Duration::from_millis(50);

/// Those of `share` that are to be made. What is damaged, or of another build, is told and made again.
pub(super) fn missing(share: &[Point], folder: &Path) -> Vec<Point> {
    let mut of_other_builds = 0;
    let is_missing = |point: &&Point| match points::read(folder, point.key) {
        Ok(kept) => kept.is_none(),
        Err(Refused::OtherBuild(_)) => {
            of_other_builds += 1;
            true
        }
        Err(Refused::Damaged(why)) => {
            eprintln!("{}: {why}; the point is made again", point.key.file(folder).display());
            true
        }
    };
    let missing = share.iter().filter(is_missing).copied().collect();
    if of_other_builds > 0 {
        eprintln!("{}: {of_other_builds} points are of another build and are made again", folder.display());
    }
    missing
}

/// Makes the points `wanted` and keeps them in `folder`. Points that another process makes are waited for.
///
/// # Errors
/// A replay fails, a point cannot be kept, or `stop` was set.
pub(super) fn make(
    sweep: &Sweep,
    streams: &[Recorded],
    wanted: &[Point],
    folder: &Path,
    log: &Log,
    stop: &AtomicBool,
) -> Result<(), SweepError> {
    let maker = Maker { sweep, streams, folder, log, stop };
    let elsewhere = wanted.par_iter().map(|point| maker.make(point).map(|done| (!done).then_some(point)));
    let mut elsewhere: Vec<&Point> = elsewhere.filter_map(Result::transpose).collect::<Result<_, _>>()?;
    while !elsewhere.is_empty() {
        std::thread::sleep(PAUSE);
        let mut left = Vec::new();
        for point in elsewhere {
            if !maker.make(point)? {
                left.push(point);
            }
        }
        elsewhere = left;
    }
    Ok(())
}

struct Maker<'a> {
    sweep: &'a Sweep,
    streams: &'a [Recorded],
    folder: &'a Path,
    log: &'a Log,
    stop: &'a AtomicBool,
}

impl Maker<'_> {
    /// Makes a point that is not there. `false` while another process makes it.
    fn make(&self, point: &Point) -> Result<bool, SweepError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(SweepError::Stopped);
        }
        let file = point.key.file(self.folder);
        let Some(_turn) = Turn::take(&file) else { return Ok(false) };
        // Another process may have made the point since.
        if !matches!(points::read(self.folder, point.key), Ok(Some(_))) {
            let stream = &self.streams[point.policy];
            let machine = point.role.machine(&self.sweep.machine(point.machine)?.spec);
            let fidelity = self.sweep.experiment.spec.fidelity.compared();
            let stats = replay(&machine, (fidelity, self.sweep.cut), stream, self.stop)?;
            let measured = Measured { stats, totals: stream.totals };
            points::write(self.folder, point.key, measured)
                .map_err(|source| SweepError::File { path: file, source })?;
        }
        self.log.done(point.cost);
        Ok(true)
    }
}
