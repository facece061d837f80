//! Spaces of machines: few replays, chosen so that they tell of thousands of designs. A design is a machine under a
//! policy.
//!
//! A first set is spread evenly. What each resource of any machine is asked for is known from a pass over the stream.
//! A surrogate learns what replays differ from that by, and says how sure it is. The designs that may be on the front
//! are replayed next, until the budget is spent.

mod axes;
mod choose;
mod front;
mod known;
mod outcome;
mod series;
mod wrong;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use self::axes::Axis;
use self::choose::{Field, Place};
use self::series::Series;
use super::sweep::{ChosenLevel, Key, Places, Plan, Point, Recorded, Streams, Sweep, SweepError, read_point};
use crate::output::ResultsFolder;
use crate::report::space::{Size, SpaceSummary};
use crate::stats::MachineStats;

/// Of the replays behind the first set, one in so many goes where least is known; of the last quarter of the budget none.
const EXPLORE: usize = 3;

/// Runs or continues the space of the file `path`; its streams and points are kept in `folder`.
///
/// # Errors
/// A file is wrong or cannot be written, a replay fails, or `stop` was set.
pub(crate) fn space(
    path: &Path,
    level: ChosenLevel,
    folder: &ResultsFolder,
    stop: &AtomicBool,
) -> Result<SpaceSummary, SweepError> {
    let sweep = Sweep::load(path, level)?;
    folder.make()?;
    let places = Places::of(folder.path());
    places.make()?;
    let streams = Streams::new(&sweep.experiment, &places.streams);
    let plan = Plan::new(&sweep, &streams.identities)?;
    let recorded = streams.have(|_| true, stop)?;
    let wrong = wrong::wrong_pixels(&sweep.experiment, &plan.streams(), &places.points, stop)?;
    let candidates = plan.candidates(&sweep, &plan.designs())?;
    let bench = Bench { sweep: &sweep, plan: &plan, recorded: &recorded, points: &places.points, stop };
    let wrong_of: Vec<u64> = wrong.iter().map(|policy| policy.wrong_pixels).collect();
    let (mut all, passes) = bench.series(&candidates, &wrong_of)?;
    let replays = bench.explore(&mut all)?;
    let size = Size {
        combinations: sweep.combined.all as f64,
        machines: sweep.len() as u64,
        left_out: sweep.combined.left_out as u64,
        why: sweep.combined.why.clone(),
        replays: replays as u64,
        budget: bench.budget() as u64,
        passes: passes as u64,
        unsure: Field::new(&all).unsure() as u64,
    };
    outcome::summary(&sweep, &all, size, wrong)
}

/// What replays are made with.
struct Bench<'a> {
    sweep: &'a Sweep,
    plan: &'a Plan,
    recorded: &'a [Recorded],
    points: &'a Path,
    stop: &'a AtomicBool,
}

impl Bench<'_> {
    fn budget(&self) -> usize {
        self.sweep.space.map_or(0, |space| space.budget.size())
    }

    /// The series of all candidates, with what is known of each; and how many passes that took.
    fn series(&self, candidates: &[Point], wrong: &[u64]) -> Result<(Vec<Series>, usize), SweepError> {
        let axes: Vec<(&str, Axis)> = self.sweep.fields().zip(self.sweep.tried().map(Axis::new)).collect();
        let (mut all, mut passes) = (Vec::new(), 0);
        for base in 0..self.sweep.experiment.machines.len() {
            for (policy, role) in self.plan.designs() {
                let of = |point: &&Point| point.policy == policy && self.sweep.base(point.machine) == base;
                let points: Vec<Point> = candidates.iter().filter(of).copied().collect();
                let (estimates, more) = known::estimates(self.sweep, &self.recorded[policy], &points, self.stop)?;
                passes += more;
                // Without a shadow-cache unit, its fields are nothing to know.
                let fields: Vec<usize> = (0..axes.len()).filter(|field| role.has_field(axes[*field].0)).collect();
                let of_fields: Vec<&Axis> = fields.iter().map(|field| &axes[*field].1).collect();
                let places: Vec<Vec<usize>> = points
                    .iter()
                    .map(|point| {
                        let all: Vec<usize> = self.sweep.places(point.machine).collect();
                        fields.iter().map(|field| all[*field]).collect()
                    })
                    .collect();
                let inputs = axes::inputs(&of_fields, &places, &estimates);
                all.push(Series::new((base, policy, wrong[policy]), points, estimates, inputs));
            }
        }
        Ok((all, passes))
    }

    /// Replays the first set, and then what its results ask for, until the budget is spent. Returns how many replays
    /// there were.
    fn explore(&self, all: &mut [Series]) -> Result<usize, SweepError> {
        let first: Vec<Key> = self.plan.points.iter().map(|point| point.key).collect();
        let is_first = |series: &Series, at: usize| first.contains(&series.designs[at].point.key);
        let places = |all: &[Series]| -> Vec<Place> {
            let of = |(at, series): (usize, &Series)| -> Vec<Place> {
                (0..series.designs.len())
                    .filter(|&design| is_first(series, design))
                    .map(|design| (at, design))
                    .collect()
            };
            all.iter().enumerate().flat_map(of).collect()
        };
        self.measure(all, &places(all), "first set")?;
        let mut done = first.len();
        let mut round = 1;
        while done < self.budget() {
            all.par_iter_mut().for_each(Series::learn);
            let left = self.budget() - done;
            let explore = if left * 4 > self.budget() { EXPLORE } else { 0 };
            let chosen = Field::new(all).choose(all, left.div_ceil(3), explore);
            if chosen.is_empty() {
                break;
            }
            // What others of the batch tell was counted in: predictions are of what was known before.
            all.par_iter_mut().for_each(Series::predict);
            self.measure(all, &chosen, &format!("round {round}"))?;
            done += chosen.len();
            round += 1;
        }
        all.par_iter_mut().for_each(Series::learn);
        Ok(done)
    }

    /// Replays designs, or takes the points that are kept.
    fn measure(&self, all: &mut [Series], places: &[Place], what: &str) -> Result<(), SweepError> {
        let wanted: Vec<Point> = places.iter().map(|&(series, design)| all[series].designs[design].point).collect();
        let subject = format!("space {} {}, {what}", self.sweep.experiment.spec.name, self.plan.identity());
        super::sweep::make_points(self.sweep, self.recorded, &wanted, self.points, subject, self.stop)?;
        for &(series, design) in places {
            let point = all[series].designs[design].point;
            let stats: MachineStats = read_point(self.points, point.key)?.stats;
            all[series].measure(design, &stats);
        }
        Ok(())
    }
}
