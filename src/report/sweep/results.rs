//! The rows of a sweep's `results.csv`, with a column for each varied field.

use super::data::{Change, SweepSummary};
use crate::report::error::ReportError;
use crate::report::results::{Family, Results, Scope, Subject, Take, Walk};

/// Fidelity levels without an error.
const EXACT: [&str; 2] = ["Event", "Cycle"];

impl Results for SweepSummary {
    fn varied(&self) -> Vec<&str> {
        let mut fields: Vec<&str> = Vec::new();
        for change in self.points.iter().flat_map(|point| &point.changes) {
            if !fields.contains(&change.field.as_str()) {
                fields.push(&change.field);
            }
        }
        fields
    }

    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let (split, own) = (Family::new("machines.*.split.*.", "split"), Family::new("points.*.", ""));
        let fields = self.varied();
        let exact = self.fidelity.as_deref().is_some_and(|level| EXACT.contains(&level));
        let half_width = |_: &str| exact.then_some(0.0);
        for point in &self.points {
            let value = |field: &&str| {
                let own = |change: &&Change| change.field == **field;
                point.changes.iter().find(own).map(|change| change.value.as_str())
            };
            let varied: Vec<Option<&str>> = fields.iter().map(value).collect();
            let machine = Some((point.machine.as_str(), self.fidelity.as_deref().unwrap_or_default()));
            let of = Subject {
                run: &self.experiment,
                scene: &self.scene,
                scope: Scope::Total,
                frame: None,
                policy: &point.policy,
                machine,
                varied: &varied,
            };
            let walk = Walk { family: &split, of, part: None, half_width: &half_width };
            point.split.rows(exact, walk, take)?;
            Walk { family: &own, part: Some("dram"), ..walk }.rows(point, take)?;
        }
        Ok(())
    }
}
