//! The rows of `results.csv` of a comparison of fidelity levels: the figures of each level for each run.

use super::data::ParetoSummary;
use super::run::{Figures, Run};
use crate::report::error::ReportError;
use crate::report::results::{Amount, Family, Results, Row, Scope, Subject, Take};

/// The figures of a run by their paths, in the order of [`Figures::all`], each with its part of the machine.
const FIGURES: [(&str, Option<&str>); 3] =
    [("cycles", None), ("bytes.l2.node", Some("l2")), ("bytes.dram.node", Some("dram"))];

impl Results for ParetoSummary {
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let family = Family::new("machines.*.policies.*.", "");
        for run in &self.runs {
            rows(&family, run, &self.truth, run.truth, Some([0.0; 3]), take)?;
            for (index, rung) in self.rungs.iter().enumerate() {
                let Some(measured) = run.found(index) else { continue };
                rows(&family, run, &rung.name, measured.figures, measured.accuracy.shares(), take)?;
            }
        }
        Ok(())
    }
}

/// Hands over the figures of a level for a run; `claimed` holds half the widths of their intervals as shares of the
/// figures.
fn rows(
    family: &Family,
    run: &Run,
    level: &str,
    figures: Figures,
    claimed: Option<[f64; 3]>,
    take: &mut Take<'_>,
) -> Result<(), ReportError> {
    let of = Subject {
        run: "pareto",
        scene: &run.scene,
        scope: Scope::Total,
        frame: None,
        policy: &run.policy,
        machine: Some((&run.machine, level)),
        varied: &[],
    };
    let counts = [figures.cycles, figures.l2_bytes, figures.dram_bytes];
    for (at, ((path, part), count)) in FIGURES.into_iter().zip(counts).enumerate() {
        let Some(metric) = family.metric(path) else { continue };
        let half_width = claimed.map(|shares| shares[at] * count as f64);
        take(&Row { of, part, class: None, metric, value: Some(Amount::Whole(count.into())), half_width })?;
    }
    Ok(())
}
