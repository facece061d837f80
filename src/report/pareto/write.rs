//! The files of a report on speed against accuracy.

use minijinja::context;
use serde::Serialize;

use super::data::ParetoSummary;
use super::plot::{self, finding};
use super::report::ParetoReport;
use super::run::Figures;
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::error::ReportError;
use crate::report::results;
use crate::report::template;
use crate::report::writer::{Report, ReportFile, json};

/// The file of times.
const TIMINGS_FILE: &str = "timings.json";

const PLOTS: &[Plot<ParetoReport>] = &[plot::PLOT];

/// Columns of `pareto.csv`: one row per run and level.
const COLUMNS: [&str; 13] = [
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
];

impl Report for ParetoReport {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        &self.summary
    }

    fn tables(&self) -> Vec<CsvTable> {
        let mut rows = Vec::new();
        for run in &self.summary.runs {
            for (index, rung) in self.summary.rungs.iter().enumerate() {
                let Some(measured) = run.found(index) else { continue };
                let mut row = vec![run.scene.clone(), run.machine.clone(), run.policy.clone(), rung.name.clone()];
                for Figures { cycles, l2_bytes, dram_bytes } in [measured.figures, run.truth] {
                    row.extend([cycles, l2_bytes, dram_bytes].map(|figure| figure.to_string()));
                }
                let claimed = measured.claimed().map(|claimed| claimed.map(|share| share.to_string()));
                row.extend(claimed.unwrap_or_default());
                rows.push(row);
            }
        }
        vec![CsvTable::new("pareto.csv", COLUMNS, rows)]
    }

    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        let timings = (TIMINGS_FILE.into(), json(TIMINGS_FILE, &self.timings)?);
        Ok(std::iter::once(timings).chain(results::files(&self.summary)?).collect())
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let ParetoSummary { truth, rungs, runs, .. } = &self.summary;
        let differ = rungs.iter().filter(|rung| !rung.disagreements.is_empty());
        let orders =
            differ.map(|rung| context! { name => rung.name.clone(), disagreements => rung.disagreements.clone() });
        let refuse = rungs.iter().filter(|rung| !rung.refusals.is_empty());
        let refused = refuse.map(|rung| context! { name => rung.name.clone(), refusals => rung.refusals.clone() });
        let context = context! {
            plots => template::plots(plots, &()),
            orders => orders.collect::<Vec<_>>(),
            refused => refused.collect::<Vec<_>>(),
            rungs => template::grid(self.summary.grid(&self.timings)),
            // The truth is the first row, and claims no error.
            silent => std::iter::once(false).chain(rungs.iter().map(|rung| rung.claimed.is_none())).collect::<Vec<_>>(),
            finding => finding(&self.summary, &self.timings),
            truth => truth.as_str(),
            runs => runs.len(),
        };
        template::render("pareto.html", include_str!("page.html"), context).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::super::data::tests::{run, summary};
    use super::super::run::{Found, Run};
    use super::super::timing::Timing;
    use super::*;
    use crate::output::ResultsFolder;
    use crate::report::writer::{SUMMARY_FILE, write};

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
        let timings = vec![timing("Event", 2.0), timing("B", 1.0)];
        let page = ParetoReport { summary: summary.clone(), timings }.page(&[]).unwrap().unwrap();
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
        let timings = vec![timing("Event", 2.0, 2000), timing("B", 0.0, 0)];
        let row = &summary.grid(&timings).rows[1];
        assert_eq!((row[1].as_str(), row[2].as_str(), row[10].as_str()), ("\u{2013}", "\u{2013}", "2"));
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(summary.frontier(&timings, |rung| rung.cycles), [false]);
        write(&ResultsFolder::claim(&folder.path().join("pareto")).unwrap(), &ParetoReport { summary, timings })
            .unwrap();
    }

    #[test]
    fn the_report_has_every_part() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("pareto");
        let (summary, timings) = summary();
        let report = ParetoReport { summary: summary.clone(), timings };
        let pages = [(); 2].map(|()| write(&ResultsFolder::claim(&target).unwrap(), &report).unwrap());
        let text = std::fs::read(target.join(SUMMARY_FILE)).unwrap();
        assert_eq!(serde_json::from_slice::<ParetoSummary>(&text).unwrap().runs, summary.runs);
        let page = std::fs::read_to_string(&pages[1]).unwrap();
        for part in ["<svg", "within", "2.0 % apart"] {
            assert!(page.contains(part), "{part}");
        }
        assert_eq!(std::fs::read_to_string(target.join("pareto.csv")).unwrap().lines().count(), 3);
    }
}
