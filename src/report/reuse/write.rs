//! The files of a report on reuse.

use minijinja::context;
use serde::Serialize;

use super::data::{ReuseSummary, grid};
use super::plot;
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::error::ReportError;
use crate::report::results;
use crate::report::template;
use crate::report::writer::{Report, ReportFile};
use crate::stats::ReuseCurve;

const PLOTS: &[Plot<ReuseSummary>] = &[plot::PLOT];

impl Report for ReuseSummary {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        let mut rows = Vec::new();
        for level in &self.levels {
            for (class, curve) in &level.classes {
                for (size, misses) in ReuseCurve::sizes().zip(&curve.misses) {
                    rows.push(vec![
                        level.name.clone(),
                        class.name().into(),
                        size.to_string(),
                        curve.accesses.to_string(),
                        misses.to_string(),
                        (misses / curve.sampled.max(1.0)).to_string(),
                    ]);
                }
            }
        }
        vec![CsvTable::new("reuse.csv", ["cache", "class", "bytes", "accesses", "misses", "miss_ratio"], rows)]
    }

    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        results::files(self)
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let context = context! {
            scene => self.scene.as_str(),
            policy => self.policy.as_str(),
            machine => self.machine.as_str(),
            of => self.of.as_str(),
            plots => template::plots(plots, &()),
            caches => template::grid(grid(self)),
        };
        template::render("profile.html", include_str!("page.html"), context).map(Some)
    }
}
