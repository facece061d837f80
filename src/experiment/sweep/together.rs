//! Points that are sampled together: those of one stream, with machines that cut it alike, and one baseline.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::thread;

use rayon::prelude::*;

use super::error::SweepError;
use super::make::{Maker, PAUSE};
use super::plan::Point;
use super::points::Key;
use super::replay::Shared;
use crate::machine::MachineSpec;
use crate::output::Turn;
use crate::stats::MachineStats;

/// The most points that share a pass. All their machines' tags and windows are in memory, and all these points are
/// lost when the process is killed. Assumed.
const MOST: usize = 32;

/// Points that share their passes.
pub(super) struct Batch<'p> {
    points: Vec<&'p Point>,
    baseline: Option<(MachineSpec, MachineStats)>,
}

impl Maker<'_> {
    /// Makes the baselines of `points`, or waits until other processes have made them.
    pub(super) fn make_baselines(&self, points: &[&Point]) -> Result<(), SweepError> {
        let mut others: BTreeMap<Key, Point> = BTreeMap::new();
        for point in points {
            if let Some(key) = point.baseline {
                let machine = self.sweep.first(self.sweep.base(point.machine));
                let role = point.role.of_baseline();
                others.insert(key, Point { key, machine, role, baseline: None, ..**point });
            }
        }
        others.par_iter().try_for_each(|(_, point)| {
            while !self.have(point)? {
                thread::sleep(PAUSE);
            }
            Ok(())
        })
    }

    /// Batches of points that share passes, and the points that share none.
    pub(super) fn batches<'p>(&self, points: &[&'p Point]) -> Result<(Vec<Batch<'p>>, Vec<&'p Point>), SweepError> {
        let mut alike: BTreeMap<(usize, usize, Option<Key>), Vec<&'p Point>> = BTreeMap::new();
        for &point in points {
            let base = self.sweep.base(point.machine);
            alike.entry((base, point.policy, point.baseline)).or_default().push(point);
        }
        let (mut batches, mut alone) = (Vec::new(), Vec::new());
        for ((base, _, key), points) in alike {
            let baseline = match key {
                None => None,
                Some(key) => {
                    let machine = &self.sweep.machine(self.sweep.first(base))?.spec;
                    let stats = super::summary::read(self.folder, key)?.stats;
                    Some((points[0].role.of_baseline().machine(machine), stats))
                }
            };
            for points in points.chunks(MOST) {
                let batch = Batch { points: points.to_vec(), baseline: baseline.clone() };
                match self.shared(&batch).is_some() {
                    true => batches.push(batch),
                    false => alone.extend(batch.points),
                }
            }
        }
        Ok((batches, alone))
    }

    fn shared<'b>(&'b self, batch: &'b Batch<'_>) -> Option<Shared<'b>> {
        let point = batch.points.first()?;
        let baseline = batch.baseline.as_ref().map(|(machine, stats)| (machine, stats));
        let level = (self.fidelity(point), self.sweep.cut(point.machine));
        Shared::of(level, baseline, &self.streams[point.policy], self.stop)
    }

    /// Makes the points of a batch. Returns the points that other processes make.
    pub(super) fn make_together<'p>(&self, batch: &Batch<'p>) -> Result<Vec<&'p Point>, SweepError> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(SweepError::Stopped);
        }
        let points = &batch.points;
        let turns: Vec<Option<Turn>> = points.iter().map(|point| Turn::take(&point.key.file(self.folder))).collect();
        let taken = points.iter().zip(&turns);
        let elsewhere = taken.clone().filter(|(_, turn)| turn.is_none()).map(|(&point, _)| point).collect();
        let here: Vec<&Point> = taken.filter(|(_, turn)| turn.is_some()).map(|(&point, _)| point).collect();
        let (made, here): (Vec<&Point>, Vec<&Point>) = here.into_iter().partition(|point| self.is_there(point));
        made.iter().for_each(|point| self.log.done(point.cost));
        let Some(shared) = self.shared(batch).filter(|_| !here.is_empty()) else { return Ok(elsewhere) };
        let machines = here.iter().map(|point| self.machine(point)).collect::<Result<Vec<_>, _>>()?;
        let verdicts = shared.sample(&machines)?;
        let sampled: Vec<_> = here.into_iter().zip(&machines).zip(verdicts).collect();
        sampled.into_par_iter().try_for_each(|((point, machine), verdict)| {
            self.keep(point, shared.stats(verdict, machine)?)?;
            self.log.done(point.cost);
            Ok::<_, SweepError>(())
        })?;
        Ok(elsewhere)
    }
}
