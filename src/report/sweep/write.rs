//! The files of a sweep's report.

use minijinja::context;
use serde::Serialize;

use super::data::{NAMES, SweepSummary, grid, hit_rates};
use super::{bytes, curves, front, heat_map, tornado};
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::error::ReportError;
use crate::report::format::counted;
use crate::report::grid::Grid;
use crate::report::results;
use crate::report::split::Split;
use crate::report::template;
use crate::report::writer::{Report, ReportFile};

/// Plots of all fields together; the curves of each come first.
const PLOTS: &[Plot<SweepSummary>] = &[heat_map::PLOT, tornado::PLOT, front::PLOT, bytes::PLOT];

/// The most rows of a table on the page; the CSV has all.
const MOST_ROWS: usize = 2_000;

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
        let mut all = curves::drawings(self)?;
        all.extend(draw_all(self, PLOTS)?);
        Ok(all)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let rates = hit_rates(self).into_iter().map(|(cache, of)| (cache, template::grid(first_rows(of))));
        let context = context! {
            experiment => self.experiment.as_str(),
            scene => self.scene.as_str(),
            finding => finding(plots),
            frames => counted(self.frames.len(), "frame"),
            count => self.points.len(),
            resolution => self.resolution.to_string(),
            points => template::grid(first_rows(grid(self))),
            hit_rates => rates.collect::<Vec<_>>(),
            plots => template::plots(plots, &()),
        };
        template::render("sweep.html", include_str!("page.html"), context).map(Some)
    }
}

/// What the plots say: what moves cycles most.
fn finding(plots: &[Drawing]) -> String {
    let order = ["sensitivity", "heat-map", "field-"];
    let found = order.iter().find_map(|name| plots.iter().find(|plot| plot.name.starts_with(name)));
    found.or(plots.first()).map_or("Nothing was varied".into(), |plot| format!("{}.", plot.title))
}

fn first_rows(mut table: Grid) -> Grid {
    table.rows.truncate(MOST_ROWS);
    table
}
