//! Spaces of machines: a few well-chosen replays predict thousands of designs. A design is a machine under a policy.
//!
//! The first set is spread evenly. Passes over the streams estimate the load of each resource of every machine. A
//! surrogate learns how replays differ from these estimates, with intervals. Designs that may be on the front are
//! replayed next, until the budget is spent.

mod axes;
mod choose;
mod figure;
mod front;
mod known;
mod outcome;
mod pool;
mod wrong;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rustc_hash::FxHashSet;

use self::axes::{Axis, Known};
use self::choose::Prospects;
use self::pool::Pool;
use super::progress;
use super::sweep::{
    ChosenLevel, Key, Places, Plan, Point, Recorded, Streams, Sweep, SweepError, make_points, read_point,
};
use crate::output::ResultsFolder;
use crate::report::space::{Size, SpaceSummary};

/// After the first set, every third replay goes to the design with the widest prediction; in the last quarter of the
/// budget none does. Both are assumed.
const EXPLORE: usize = 3;

/// Runs or continues the space of the file `path`; keeps its streams and points in `folder`.
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
    let (mut pool, passes) = bench.pool(&candidates, &wrong_of)?;
    let replays = bench.explore(&mut pool)?;
    let size = Size {
        combinations: sweep.combined.all as f64,
        machines: sweep.len() as u64,
        left_out: sweep.combined.left_out as u64,
        why: sweep.combined.why.clone(),
        replays: replays as u64,
        budget: bench.budget() as u64,
        passes: passes as u64,
        unsure: Prospects::new(&pool).unsure() as u64,
    };
    outcome::summary(&sweep, &pool, size, wrong)
}

/// Everything that a replay needs.
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

    /// All candidates with their estimates, and the number of passes these took.
    fn pool(&self, candidates: &[Point], wrong: &[u64]) -> Result<(Pool, usize), SweepError> {
        let (mut points, mut estimates, mut passes) = (Vec::new(), Vec::new(), 0);
        let bar = progress::bar("finding what caches miss", candidates.len(), "designs");
        for base in 0..self.sweep.experiment.machines.len() {
            for (policy, &wrong) in wrong.iter().enumerate() {
                let of = |point: &&Point| point.policy == policy && self.sweep.base(point.machine) == base;
                let some: Vec<Point> = candidates.iter().filter(of).copied().collect();
                let kept = (self.points, self.stop);
                let (found, more) = known::estimates(self.sweep, &self.recorded[policy], &some, kept, &bar)?;
                points.extend(some.into_iter().map(|point| (point, wrong)));
                estimates.extend(found);
                passes += more;
            }
        }
        // A surrogate knows a design by its machine in the experiment, its policy, and the values of its fields.
        let names = [Axis::Names(self.sweep.experiment.machines.len()), Axis::Names(wrong.len())];
        let axes: Vec<Axis> = names.into_iter().chain(self.sweep.tried().map(Axis::new)).collect();
        let places = |(point, _): &(Point, u64)| -> Vec<Option<usize>> {
            let fields = self.sweep.fields().zip(self.sweep.places(point.machine));
            let fields = fields.map(|(path, place)| point.role.has_field(path).then_some(place));
            [Some(self.sweep.base(point.machine)), Some(point.policy)].into_iter().chain(fields).collect()
        };
        let places: Vec<Vec<Option<usize>>> = points.iter().map(places).collect();
        let known = Known { axes: &axes, places: &places, estimates: &estimates };
        Ok((Pool::new(points, &known), passes))
    }

    /// Replays the first set and then the chosen designs, until the budget is spent. Returns the number of replays.
    fn explore(&self, pool: &mut Pool) -> Result<usize, SweepError> {
        let first: FxHashSet<Key> = self.plan.points.iter().map(|point| point.key).collect();
        let is_first = |at: &usize| first.contains(&pool.designs[*at].point.key);
        let places: Vec<usize> = (0..pool.designs.len()).filter(is_first).collect();
        self.measure(pool, &places, "first set")?;
        let mut done = places.len();
        for round in 1.. {
            pool.learn();
            let left = self.budget().saturating_sub(done);
            let explore = if left * 4 > self.budget() { EXPLORE } else { 0 };
            let chosen = Prospects::new(pool).choose(pool, left.div_ceil(3), explore);
            // `choose` narrowed predictions as if the batch were known: predicts again from measured designs alone.
            pool.predict();
            if chosen.is_empty() {
                break;
            }
            self.measure(pool, &chosen, &format!("round {round}"))?;
            done += chosen.len();
        }
        Ok(done)
    }

    /// Replays designs, or reads their points if these are kept.
    fn measure(&self, pool: &mut Pool, designs: &[usize], what: &str) -> Result<(), SweepError> {
        let wanted: Vec<Point> = designs.iter().map(|&design| pool.designs[design].point).collect();
        let subject = format!("space {} {}, {what}", self.sweep.experiment.spec.name, self.plan.identity());
        make_points(self.sweep, self.recorded, &wanted, self.points, subject, self.stop)?;
        for (&design, point) in designs.iter().zip(wanted) {
            pool.measure(design, &read_point(self.points, point.key)?.stats);
        }
        Ok(())
    }
}
