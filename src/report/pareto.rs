//! Speed against accuracy of the rungs of the ladder: tables, a chart and a page. Times differ from run to run, and lie apart from all
//! that does not.

use minijinja::context;
use serde::{Deserialize, Serialize};

use super::format::{or_absent, percent, short};
use super::rung::{Rung, Spread};
use super::table::Grid;
use super::{PAGE_FILE, PLOTS_FOLDER, ReportError, SUMMARY_FILE, plots, put, replace, template};
use crate::output::ResultsFolder;
use crate::stats::{Accuracy, MachineStats};

/// The version of the names in `summary.json`.
const SCHEMA: u32 = 2;
/// The file with a row for each run and rung.
const RUNS_FILE: &str = "pareto.csv";
/// The file with times.
const TIMINGS_FILE: &str = "timings.json";

/// What every rung found, and how far off it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParetoSummary {
    /// The version of these names.
    pub schema: u32,
    /// The rung that the others are held to.
    pub truth: String,
    /// The policies, in the order in which they first occur.
    pub policies: Vec<String>,
    /// What the rungs are off by, in the order of the file.
    pub rungs: Vec<Rung>,
    /// All runs.
    pub runs: Vec<Run>,
}

/// A machine on the stream of a policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The scene.
    pub scene: String,
    /// The machine.
    pub machine: String,
    /// The machine's clock.
    pub clock_mhz: u64,
    /// The policy.
    pub policy: String,
    /// Whether savings are measured against it.
    pub is_baseline: bool,
    /// The truth.
    pub truth: Figures,
    /// What each rung found.
    pub rungs: Vec<Found>,
}

/// What became of a run by a rung.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Found {
    /// It was replayed.
    Measured(Measured),
    /// The rung refused it.
    Refused {
        /// Why.
        refused: String,
    },
}

impl Run {
    /// What a rung found, if it did not refuse the run.
    pub(super) fn found(&self, rung: usize) -> Option<&Measured> {
        match &self.rungs[rung] {
            Found::Measured(measured) => Some(measured),
            Found::Refused { .. } => None,
        }
    }
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Figures {
    /// Cycles.
    pub cycles: u64,
    /// Bytes between L1s and L2.
    pub l2_bytes: u64,
    /// Bytes of the DRAM.
    pub dram_bytes: u64,
}

impl Figures {
    /// From a run's statistics.
    pub fn of(stats: &MachineStats) -> Self {
        let l2 = stats.bytes.keys().filter(|level| level.starts_with("l2"));
        Self {
            cycles: stats.cycles.0,
            l2_bytes: l2.map(|level| stats.moved(level).0).sum(),
            dram_bytes: stats.moved("dram").0,
        }
    }

    /// All, in this order.
    pub(super) fn all(self) -> [f64; 3] {
        [self.cycles, self.l2_bytes, self.dram_bytes].map(|figure| figure as f64)
    }
}

/// What a rung found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The figures.
    #[serde(flatten)]
    pub figures: Figures,
    /// What it says of their error.
    pub accuracy: Accuracy,
}

impl Measured {
    /// Half the widths of its intervals over the figures.
    pub(super) fn claimed(&self) -> Option<[f64; 3]> {
        self.accuracy.shares().filter(|_| self.accuracy != Accuracy::Exact)
    }
}

/// How long a rung took for all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// The rung.
    pub rung: String,
    /// Wall time of the runs that it did not refuse, reading of the streams included.
    pub seconds: f64,
    /// That of the truth for the same runs.
    pub truth_seconds: f64,
    /// Rays of their streams.
    pub rays: u64,
}

impl Timing {
    /// A run that took so long, and the truth for it, on a stream of so many rays.
    pub fn add(&mut self, seconds: f64, truth_seconds: f64, rays: u64) {
        self.seconds += seconds;
        self.truth_seconds += truth_seconds;
        self.rays += rays;
    }

    /// Rays of the stream a second of wall time; none if all runs were refused.
    pub fn speed(&self) -> Option<f64> {
        (self.rays > 0).then(|| self.rays as f64 / self.seconds.max(1e-9))
    }

    /// How many times as fast as the truth it was.
    fn times(&self) -> Option<f64> {
        (self.rays > 0).then(|| self.truth_seconds / self.seconds.max(1e-9))
    }
}

impl ParetoSummary {
    /// Compares the runs.
    pub fn new(truth: String, rungs: Vec<String>, runs: Vec<Run>) -> Self {
        let mut policies: Vec<String> = Vec::new();
        for run in &runs {
            if !policies.contains(&run.policy) {
                policies.push(run.policy.clone());
            }
        }
        let rungs = rungs.into_iter().enumerate().map(|(index, name)| Rung::new(name, index, &runs)).collect();
        Self { schema: SCHEMA, truth, policies, rungs, runs }
    }

    /// The rungs, with their speed, that none beats in both speed and mean error of `figure`.
    pub fn frontier(&self, timings: &[Timing], figure: fn(&Rung) -> Option<Spread>) -> Vec<bool> {
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

    /// A row a rung.
    pub fn grid(&self, timings: &[Timing]) -> Grid {
        const HEAD: [&str; 11] = [
            "rung",
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

fn csv(summary: &ParetoSummary) -> Result<Vec<u8>, csv::Error> {
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record([
        "scene",
        "machine",
        "policy",
        "rung",
        "cycles",
        "l2_bytes",
        "dram_bytes",
        "true_cycles",
        "true_l2_bytes",
        "true_dram_bytes",
        "claimed_cycles",
        "claimed_l2_bytes",
        "claimed_dram_bytes",
    ])?;
    for run in &summary.runs {
        for (index, rung) in summary.rungs.iter().enumerate() {
            let Some(measured) = run.found(index) else { continue };
            let mut row = vec![run.scene.clone(), run.machine.clone(), run.policy.clone(), rung.name.clone()];
            for Figures { cycles, l2_bytes, dram_bytes } in [measured.figures, run.truth] {
                row.extend([cycles, l2_bytes, dram_bytes].map(|figure| figure.to_string()));
            }
            let claimed = measured.claimed().map(|claimed| claimed.map(|share| share.to_string()));
            row.extend(claimed.unwrap_or_default());
            csv.write_record(row)?;
        }
    }
    csv.into_inner().map_err(|error| error.into_error().into())
}

/// Writes the report at `target`, in the place of an earlier one if there is one, complete or not at all.
pub fn write_pareto(folder: &ResultsFolder, summary: &ParetoSummary, timings: &[Timing]) -> Result<(), ReportError> {
    replace(folder, |dir| {
        let json = |text: Result<Vec<u8>, _>| text.map_err(ReportError::Summary);
        put(&dir.join(SUMMARY_FILE), &json(serde_json::to_vec_pretty(summary))?)?;
        put(&dir.join(TIMINGS_FILE), &json(serde_json::to_vec_pretty(timings))?)?;
        put(&dir.join(RUNS_FILE), &csv(summary).map_err(ReportError::Table)?)?;
        let plot = plots::pareto::draw(summary, timings).map_err(ReportError::Plot)?;
        put(&dir.join(PLOTS_FOLDER).join("pareto.svg"), plot.as_bytes())?;
        let page = page(summary, timings, &plot).map_err(ReportError::Page)?;
        put(&dir.join(PAGE_FILE), page.as_bytes())
    })
}

fn page(summary: &ParetoSummary, timings: &[Timing], plot: &str) -> Result<String, minijinja::Error> {
    let differ = summary.rungs.iter().filter(|rung| !rung.disagreements.is_empty());
    let orders: Vec<_> = differ
        .map(|rung| context! { name => rung.name.clone(), disagreements => rung.disagreements.clone() })
        .collect();
    let refuse = summary.rungs.iter().filter(|rung| !rung.refusals.is_empty());
    let refused: Vec<_> =
        refuse.map(|rung| context! { name => rung.name.clone(), refusals => rung.refusals.clone() }).collect();
    let context = context! {
        plot, orders, refused,
        rungs => template::grid(summary.grid(timings)),
        truth => summary.truth.as_str(),
        runs => summary.runs.len(),
    };
    template::render("pareto.html", include_str!("pareto.html"), context)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(policy: &str, truth: u64, found: u64) -> Run {
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
            })],
        }
    }

    fn summary() -> (ParetoSummary, Vec<Timing>) {
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
        // Of seven figures that are claimed one lies outside: the cycles of `A`. What `A` saves is within twice as much.
        assert_eq!(rung.within, Some([6, 7]));
        close(rung.claimed.unwrap()[3].unwrap(), 1100.0 / 1020.0 * 0.1);
        close(rung.saving.unwrap().worst, 1100.0 / 1020.0 - 0.98);
        assert_eq!(rung.disagreements, ["room on `small`: `Off` and `A`, which are 2.0 % apart"]);
        assert_eq!(summary.frontier(&timings, |rung| rung.cycles), [true]);
        let slow = [timings[0].clone(), Timing { seconds: 3.0, ..timings[1].clone() }];
        assert_eq!(summary.frontier(&slow, |rung| rung.cycles), [false]);
    }

    #[test]
    fn what_a_rung_refuses_is_told_and_left_out() {
        let refused = Found::Refused { refused: "too short".into() };
        let runs = vec![run("Off", 1000, 1020), Run { rungs: vec![refused], ..run("A", 980, 0) }];
        let summary = ParetoSummary::new("Event".into(), vec!["B".into()], runs);
        let rung = &summary.rungs[0];
        assert_eq!(rung.refusals, ["room on `small` under `A`: too short"]);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(rung.cycles.unwrap().worst, 0.02);
        assert!(rung.saving.is_none() && rung.disagreements.is_empty());
        assert_eq!(rung.within, Some([3, 3]));
        let timing = |rung: &str, seconds| Timing { rung: rung.into(), seconds, truth_seconds: 2.0, rays: 1000 };
        let page = page(&summary, &[timing("Event", 2.0), timing("B", 1.0)], "").unwrap();
        assert!(page.contains("room on <code>small</code> under <code>A</code>: too short"), "{page}");
        let json = serde_json::to_vec(&summary).unwrap();
        assert_eq!(serde_json::from_slice::<ParetoSummary>(&json).unwrap(), summary);
    }

    #[test]
    fn a_rung_that_refused_every_run_has_no_speed() {
        let refused = || vec![Found::Refused { refused: "too short".into() }];
        let runs = vec![Run { rungs: refused(), ..run("Off", 1000, 0) }, Run { rungs: refused(), ..run("A", 980, 0) }];
        let summary = ParetoSummary::new("Event".into(), vec!["B".into()], runs);
        let timing = |rung: &str, seconds, rays| Timing { rung: rung.into(), seconds, truth_seconds: seconds, rays };
        let timings = [timing("Event", 2.0, 2000), timing("B", 0.0, 0)];
        let row = &summary.grid(&timings).rows[1];
        assert_eq!((row[1].as_str(), row[2].as_str(), row[10].as_str()), ("\u{2013}", "\u{2013}", "2"));
        let folder = tempfile::tempdir().unwrap();
        write_pareto(&ResultsFolder::claim(&folder.path().join("pareto")).unwrap(), &summary, &timings).unwrap();
        assert_eq!(summary.frontier(&timings, |rung| rung.cycles), [false]);
    }

    #[test]
    fn the_report_has_every_part() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("pareto");
        let (summary, timings) = summary();
        (0..2).for_each(|_| write_pareto(&ResultsFolder::claim(&target).unwrap(), &summary, &timings).unwrap());
        let text = std::fs::read(target.join(SUMMARY_FILE)).unwrap();
        assert_eq!(serde_json::from_slice::<ParetoSummary>(&text).unwrap().runs, summary.runs);
        let page = std::fs::read_to_string(target.join(PAGE_FILE)).unwrap();
        for part in ["<svg", "within", "2.0 % apart"] {
            assert!(page.contains(part), "{part}");
        }
        assert_eq!(std::fs::read_to_string(target.join(RUNS_FILE)).unwrap().lines().count(), 3);
    }
}
