//! Speed against accuracy of the fidelity levels.

use serde::{Deserialize, Serialize};

use super::level::{Rung, Spread};
use super::run::Run;
use super::timing::Timing;
use crate::report::format::{or_absent, percent, short};
use crate::report::grid::Grid;

/// The version of the names in `summary.json`.
const SCHEMA: u32 = 2;

/// The figures of every fidelity level, and their errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ParetoSummary {
    /// The version of these names.
    pub schema: u32,
    /// The level that is taken as the truth.
    pub truth: String,
    /// The policies, in the order in which they first occur.
    pub policies: Vec<String>,
    /// Errors of the levels, in the order of the file.
    pub rungs: Vec<Rung>,
    /// All runs.
    pub runs: Vec<Run>,
}

impl ParetoSummary {
    /// Compares the runs.
    pub(crate) fn new(truth: String, rungs: Vec<String>, runs: Vec<Run>) -> Self {
        let mut policies: Vec<String> = Vec::new();
        for run in &runs {
            if !policies.contains(&run.policy) {
                policies.push(run.policy.clone());
            }
        }
        let rungs = rungs.into_iter().enumerate().map(|(index, name)| Rung::new(name, index, &runs)).collect();
        Self { schema: SCHEMA, truth, policies, rungs, runs }
    }

    /// For each level, whether no other level beats it in both speed and mean error of `figure`.
    pub(crate) fn frontier(&self, timings: &[Timing], figure: fn(&Rung) -> Option<Spread>) -> Vec<bool> {
        let points: Vec<_> =
            self.rungs.iter().zip(timings.iter().skip(1)).map(|(rung, it)| (it.speed(), figure(rung))).collect();
        let truth = timings.first().map(|truth| (truth.speed(), Some(Spread { mean: 0.0, worst: 0.0 })));
        let beaten = |&(speed, error): &(Option<f64>, Option<Spread>)| {
            let Some(error) = error else { return true };
            points.iter().chain(&truth).any(|(other_speed, other)| {
                other.is_some_and(|other| {
                    *other_speed >= speed
                        && other.mean <= error.mean
                        && (*other_speed > speed || other.mean < error.mean)
                })
            })
        };
        points.iter().map(|point| !beaten(point)).collect()
    }

    /// Names the levels that no other level beats in both speed and error of cycles.
    pub(crate) fn verdict(&self, timings: &[Timing]) -> String {
        let front = self.frontier(timings, |rung| rung.cycles);
        let names = self.rungs.iter().zip(front).filter(|(_, is_front)| *is_front).map(|(rung, _)| rung.name.as_str());
        let names: Vec<&str> = names.collect();
        format!("no level is both faster and closer to {} than: {}", self.truth, names.join("; "))
    }

    /// One row per level.
    pub(crate) fn grid(&self, timings: &[Timing]) -> Grid {
        const HEAD: [&str; 11] = [
            "level",
            "rays/s",
            "times the truth's speed",
            "cycles",
            "L2",
            "DRAM",
            "saving",
            "claimed (cycles, L2, DRAM, saving)",
            "within",
            "other orders",
            "refused",
        ];
        let truth = timings.first().and_then(Timing::speed);
        let spread =
            |spread: Option<Spread>| or_absent(spread, |it| format!("{} ({})", percent(it.mean), percent(it.worst)));
        let of_truth = std::iter::once({
            let mut row = vec![self.truth.clone(), or_absent(truth, short), "1".into()];
            row.resize(HEAD.len(), "\u{2013}".into());
            row
        });
        let row = |(rung, timing): (&Rung, &Timing)| {
            vec![
                rung.name.clone(),
                or_absent(timing.speed(), short),
                or_absent(timing.times(), |times| format!("{times:.1}")),
                spread(rung.cycles),
                spread(rung.l2_bytes),
                spread(rung.dram_bytes),
                spread(rung.saving),
                or_absent(rung.claimed, |it| it.map(|share| or_absent(share, percent)).join(", ")),
                or_absent(rung.within, |[within, all]| format!("{within} of {all}")),
                rung.disagreements.len().to_string(),
                rung.refusals.len().to_string(),
            ]
        };
        let rows = of_truth.chain(self.rungs.iter().zip(timings.iter().skip(1)).map(row)).collect();
        Grid { head: HEAD.map(Into::into).to_vec(), names: 1, rows }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::run::{Figures, Found, Measured};
    use super::*;
    use crate::stats::Accuracy;

    pub(crate) fn run(policy: &str, truth: u64, found: u64) -> Run {
        let figures = |cycles| Figures { cycles, l2_bytes: 100, dram_bytes: 0 };
        Run {
            scene: "room".into(),
            machine: "small".into(),
            clock_mhz: 500,
            policy: policy.into(),
            is_baseline: policy == "Off",
            truth: figures(truth),
            rungs: vec![Found::Measured(Measured {
                figures: figures(found),
                accuracy: Accuracy::Estimated { cycles: 0.05, l2_bytes: 0.0, dram_bytes: 0.0, rate: 0.1 },
                residuals: None,
            })],
        }
    }

    pub(crate) fn summary() -> (ParetoSummary, Vec<Timing>) {
        let runs = vec![run("Off", 1000, 1020), run("A", 980, 1100)];
        let timing = |rung: &str, seconds| Timing { rung: rung.into(), seconds, truth_seconds: 2.0, rays: 1000 };
        (ParetoSummary::new("Event".into(), vec!["B".into()], runs), vec![timing("Event", 2.0), timing("B", 1.0)])
    }

    #[test]
    fn errors_orders_and_intervals_are_told() {
        let (summary, timings) = summary();
        let rung = &summary.rungs[0];
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        let cycles = rung.cycles.unwrap();
        close(cycles.worst, 1100.0 / 980.0 - 1.0);
        close(cycles.mean, (0.02 + 1100.0 / 980.0 - 1.0) / 2.0);
        assert_eq!(rung.dram_bytes, None);
        // One of the seven claimed figures lies outside its interval: the cycles of `A`. The saving of `A` lies
        // within an interval that is twice as wide.
        assert_eq!(rung.within, Some([6, 7]));
        close(rung.claimed.unwrap()[3].unwrap(), 1100.0 / 1020.0 * 0.1);
        close(rung.saving.unwrap().worst, 1100.0 / 1020.0 - 0.98);
        assert_eq!(rung.disagreements, ["room on `small`: `Off` and `A`, which are 2.0 % apart"]);
        assert_eq!(summary.frontier(&timings, |rung| rung.cycles), [true]);
        let slow = [timings[0].clone(), Timing { seconds: 3.0, ..timings[1].clone() }];
        assert_eq!(summary.frontier(&slow, |rung| rung.cycles), [false]);
    }
}
