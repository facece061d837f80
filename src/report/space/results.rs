//! The rows of a space's `results.csv`, with a column for each varied field.

use super::data::SpaceSummary;
use crate::report::error::ReportError;
use crate::report::results::{Family, Results, Scope, Subject, Take, Walk};

impl Results for SpaceSummary {
    fn varied(&self) -> Vec<&str> {
        self.fields()
    }

    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let family = Family::new("designs.*.", "");
        let fields = self.fields();
        for design in &self.designs {
            let varied: Vec<Option<&str>> = fields.iter().map(|field| design.value(field)).collect();
            let level = if design.replayed { self.fidelity.as_str() } else { "predicted" };
            let of = Subject {
                run: &self.experiment,
                scene: &self.scene,
                scope: Scope::Total,
                frame: None,
                policy: &design.policy,
                machine: Some((&design.machine, level)),
                varied: &varied,
            };
            let exact = |figure: &str| figure == "wrong_pixels" || design.replayed && self.is_exact();
            let half_width = |path: &str| {
                let own = design.half_widths.get(path).copied();
                own.or_else(|| exact(path).then_some(0.0))
            };
            let numbers = Numbers {
                wrong_pixels: design.wrong_pixels,
                cycles: design.cycles,
                dram_bytes: design.dram_bytes,
                joules: design.joules,
            };
            Walk { family: &family, of, part: None, half_width: &half_width }.rows(&numbers, take)?;
        }
        Ok(())
    }
}

/// The figures of a design.
#[derive(serde::Serialize)]
struct Numbers {
    wrong_pixels: u64,
    cycles: f64,
    dram_bytes: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    joules: Option<f64>,
}
