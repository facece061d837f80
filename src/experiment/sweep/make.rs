//! Makes the points of a share that are not kept yet, several at a time, each by one process.

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
use crate::console;
use crate::machine::MachineSpec;
use crate::output::Turn;
use crate::replay::Fidelity;
use crate::stats::MachineStats;

/// Pause before a process looks again for a point that another process makes. Assumed.
pub(super) const PAUSE: Duration = Duration::from_millis(50);

/// The points of `share` that are not kept. Damaged points and those of another build are reported and made again.
pub(super) fn missing(share: &[Point], folder: &Path) -> Vec<Point> {
    let mut of_other_builds = 0;
    let is_missing = |point: &&Point| match points::read(folder, point.key) {
        Ok(kept) => kept.is_none(),
        Err(Refused::OtherBuild(_)) => {
            of_other_builds += 1;
            true
        }
        Err(Refused::Damaged(why)) => {
            console::tell(format_args!("{}: {why}; the point is made again", point.key.file(folder).display()));
            true
        }
    };
    let missing = share.iter().filter(is_missing).copied().collect();
    if of_other_builds > 0 {
        console::tell(format_args!(
            "{}: {of_other_builds} points are of another build and are made again",
            folder.display()
        ));
    }
    missing
}

/// Makes the points `wanted`, keeps them in `folder`, and waits for those that other processes make.
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
    let (baselines, others): (Vec<&Point>, Vec<&Point>) = wanted.iter().partition(|point| point.baseline.is_none());
    let mut elsewhere = maker.make_all(&baselines)?;
    maker.make_baselines(&others)?;
    elsewhere.extend(maker.make_all(&others)?);
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

pub(super) struct Maker<'a> {
    pub(super) sweep: &'a Sweep,
    pub(super) streams: &'a [Recorded],
    pub(super) folder: &'a Path,
    pub(super) log: &'a Log,
    pub(super) stop: &'a AtomicBool,
}

impl Maker<'_> {
    /// Makes points, together where they share passes. Returns the points that other processes make.
    fn make_all<'p>(&self, points: &[&'p Point]) -> Result<Vec<&'p Point>, SweepError> {
        let (batches, alone) = self.batches(points)?;
        let mut elsewhere = Vec::new();
        for batch in batches {
            elsewhere.extend(self.make_together(&batch)?);
        }
        let alone = alone.par_iter().map(|&point| self.make(point).map(|done| (!done).then_some(point)));
        elsewhere.extend(alone.filter_map(Result::transpose).collect::<Result<Vec<_>, _>>()?);
        Ok(elsewhere)
    }

    /// Makes a point. Returns `false` while another process makes it.
    fn make(&self, point: &Point) -> Result<bool, SweepError> {
        let is_made = self.have(point)?;
        if is_made {
            self.log.done(point.cost);
        }
        Ok(is_made)
    }

    /// Makes a point without logging it. Returns `false` while another process makes it.
    pub(super) fn have(&self, point: &Point) -> Result<bool, SweepError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(SweepError::Stopped);
        }
        let file = point.key.file(self.folder);
        let Some(_turn) = Turn::take(&file) else { return Ok(false) };
        if !self.is_there(point) {
            let machine = self.machine(point)?;
            let level = (self.fidelity(point), self.sweep.cut(point.machine));
            self.keep(point, replay(&machine, level, &self.streams[point.policy], self.stop)?)?;
        }
        Ok(true)
    }

    /// Whether a point is kept: another process may have made it in the meantime.
    pub(super) fn is_there(&self, point: &Point) -> bool {
        matches!(points::read(self.folder, point.key), Ok(Some(_)))
    }

    /// The machine that is replayed for a point.
    pub(super) fn machine(&self, point: &Point) -> Result<MachineSpec, SweepError> {
        Ok(point.role.machine(&self.sweep.machine(point.machine)?.spec))
    }

    /// The fidelity level of a point's replay, which is compared with other replays.
    pub(super) fn fidelity(&self, point: &Point) -> Fidelity {
        let fidelity = self.sweep.experiment.spec.fidelity;
        if point.baseline.is_some() { fidelity.compared() } else { fidelity.of_baseline() }
    }

    /// Keeps the measurements of a point's replay.
    pub(super) fn keep(&self, point: &Point, stats: MachineStats) -> Result<(), SweepError> {
        let measured = Measured { stats, totals: self.streams[point.policy].totals };
        points::write(self.folder, point.key, measured)
            .map_err(|source| SweepError::File { path: point.key.file(self.folder), source })
    }
}
