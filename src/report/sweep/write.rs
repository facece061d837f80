//! The files of a sweep's report.

use minijinja::context;
use serde::Serialize;

use super::data::{NAMES, SweepSummary, grid, hit_rates};
use super::plot;
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::error::ReportError;
use crate::report::results;
use crate::report::split::Split;
use crate::report::template;
use crate::report::writer::{Report, ReportFile};

const PLOTS: &[Plot<SweepSummary>] = &[plot::PLOT];

impl Report for SweepSummary {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        let head = NAMES.into_iter().chain(Split::FIELDS.map(|(name, _)| name));
        let rows = self
            .points
            .iter()
            .map(|point| point.names().into_iter().chain(Split::FIELDS.map(|(_, text)| text(&point.split))).collect());
        vec![CsvTable::new("sweep.csv", head, rows.collect())]
    }

    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        results::files(self)
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let rates = hit_rates(self).into_iter().map(|(cache, of)| (cache, template::grid(of)));
        let context = context! {
            experiment => self.experiment.as_str(),
            scene => self.scene.as_str(),
            frames => self.frames.len(),
            resolution => self.resolution.to_string(),
            points => template::grid(grid(self)),
            hit_rates => rates.collect::<Vec<_>>(),
            plots => template::plots(plots, &()),
        };
        template::render("sweep.html", include_str!("page.html"), context).map(Some)
    }
}
