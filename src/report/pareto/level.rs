//! The errors of a fidelity level, over all runs of a comparison.

use serde::{Deserialize, Serialize};

use super::run::{Figures, Found, Run};
use crate::report::format::percent;
use crate::stats::half_width_of_ratio;

/// The errors of a level, over all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Rung {
    /// Its name.
    pub name: String,
    /// Error of the cycles, as a share of the truth.
    pub cycles: Option<Spread>,
    /// Error of the bytes between L1s and L2.
    pub l2_bytes: Option<Spread>,
    /// Error of the DRAM bytes.
    pub dram_bytes: Option<Spread>,
    /// Error of the share of cycles that a policy saves.
    pub saving: Option<Spread>,
    /// Mean half width of the 95 % intervals that it claims for cycles, L2 bytes, DRAM bytes and savings.
    pub claimed: Option<[Option<f64>; 4]>,
    /// Number of figures that lay in their interval, and number of figures with an interval.
    pub within: Option<[usize; 2]>,
    /// Pairs of policies or of machines whose order differs from that of the truth.
    pub disagreements: Vec<String>,
    /// Runs that it refused, and why.
    pub refusals: Vec<String>,
}

/// Mean and largest of some errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spread {
    /// The mean.
    pub mean: f64,
    /// The largest.
    pub worst: f64,
}

impl Spread {
    fn of(errors: impl Iterator<Item = f64>) -> Option<Self> {
        let errors: Vec<f64> = errors.collect();
        let worst = errors.iter().copied().reduce(f64::max)?;
        Some(Self { mean: errors.iter().sum::<f64>() / errors.len() as f64, worst })
    }
}

fn off_by(found: f64, truth: f64) -> Option<f64> {
    (truth > 0.0).then(|| (found / truth - 1.0).abs())
}

impl Rung {
    /// The errors of level number `index`.
    pub(super) fn new(name: String, index: usize, runs: &[Run]) -> Self {
        let figure = |figure: usize| {
            let error = |run: &Run| off_by(run.found(index)?.figures.all()[figure], run.truth.all()[figure]);
            Spread::of(runs.iter().filter_map(error))
        };
        let baseline = |run: &Run| {
            runs.iter().find(|other| other.is_baseline && other.scene == run.scene && other.machine == run.machine)
        };
        let saved = |with: Figures, without: Figures| 1.0 - with.cycles as f64 / without.cycles.max(1) as f64;
        let off = |run: &Run| baseline(run).filter(|_| !run.is_baseline);
        let saving = |run: &Run| {
            let off = off(run)?;
            let [with, without] = [run.found(index)?, off.found(index)?];
            Some((saved(with.figures, without.figures) - saved(run.truth, off.truth)).abs())
        };
        let of_figures = runs.iter().filter_map(|run| Some((run, run.found(index)?))).flat_map(|(run, measured)| {
            let (found, truth) = (measured.figures.all(), run.truth.all());
            let claimed = measured.claimed().into_iter();
            claimed.flat_map(move |claimed| {
                (0..3).map(move |it| ((found[it] - truth[it]).abs() <= claimed[it] * found[it], claimed[it], it))
            })
        });
        let of_saving = runs.iter().filter_map(|run| {
            let off = off(run)?;
            let [with, without] = [run.found(index)?, off.found(index)?];
            let ratio = 1.0 - saved(with.figures, without.figures);
            let claimed = half_width_of_ratio([with.trust(), without.trust()], 0, ratio)?;
            Some((saving(run)? <= claimed, claimed, 3))
        });
        let intervals: Vec<(bool, f64, usize)> = of_figures.chain(of_saving).collect();
        let claimed = |figure: usize| {
            let of_figure = || intervals.iter().filter(move |(_, _, it)| *it == figure);
            let count = of_figure().count();
            (count > 0).then(|| of_figure().map(|(_, claimed, _)| claimed).sum::<f64>() / count as f64)
        };
        Self {
            name,
            cycles: figure(0),
            l2_bytes: figure(1),
            dram_bytes: figure(2),
            saving: Spread::of(runs.iter().filter_map(saving)),
            claimed: (!intervals.is_empty()).then(|| [0, 1, 2, 3].map(claimed)),
            within: (!intervals.is_empty())
                .then(|| [intervals.iter().filter(|(within, ..)| *within).count(), intervals.len()]),
            disagreements: disagreements(index, runs),
            refusals: runs.iter().filter_map(|run| refusal(index, run)).collect(),
        }
    }
}

/// Pairs of runs that differ in the policy only, or in the machine only, and whose order by time is not that of the
/// truth.
fn disagreements(index: usize, runs: &[Run]) -> Vec<String> {
    let time = |figures: Figures, run: &Run| figures.cycles as f64 / run.clock_mhz as f64;
    let mut found = Vec::new();
    for (at, a) in runs.iter().enumerate() {
        for b in &runs[at + 1..] {
            let [same_machine, same_policy] = [a.machine == b.machine, a.policy == b.policy];
            if a.scene != b.scene || same_machine == same_policy {
                continue;
            }
            let (Some(of_a), Some(of_b)) = (a.found(index), b.found(index)) else { continue };
            let truth = time(a.truth, a).total_cmp(&time(b.truth, b));
            let order = time(of_a.figures, a).total_cmp(&time(of_b.figures, b));
            if order != truth {
                let (of, one, other) = if same_machine {
                    (format!("on `{}`", a.machine), &a.policy, &b.policy)
                } else {
                    (format!("under `{}`", a.policy), &a.machine, &b.machine)
                };
                let apart = percent((time(a.truth, a) / time(b.truth, b) - 1.0).abs());
                found.push(format!("{} {of}: `{one}` and `{other}`, which are {apart} apart", a.scene));
            }
        }
    }
    found
}

/// The reason why a level refused a run; `None` if it did not.
fn refusal(index: usize, run: &Run) -> Option<String> {
    let Found::Refused { refused } = &run.rungs[index] else { return None };
    Some(format!("{} on `{}` under `{}`: {refused}", run.scene, run.machine, run.policy))
}
