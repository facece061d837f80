//! The files of a sweep's report.

use minijinja::context;
use serde::Serialize;

use super::data::{Effect, NAMES, SweepPoint, SweepSummary, grid, hit_rates};
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

/// Plots of all fields together; the curves of each field come before them.
const PLOTS: &[Plot<SweepSummary>] = &[heat_map::PLOT, tornado::PLOT, front::PLOT, bytes::PLOT];

/// The most rows of a table on the page; the CSV has all.
const MOST_ROWS: usize = 2_000;

impl Report for SweepSummary {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        let head = NAMES.into_iter().chain(Split::FIELDS.map(|(name, _)| name)).chain(Effect::FIELDS);
        let row = |point: &SweepPoint| {
            let split = Split::FIELDS.map(|(_, text)| text(&point.split));
            point.names().into_iter().chain(split).chain(Effect::fields(point.effect.as_ref())).collect()
        };
        let rows = self.points.iter().map(row);
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
            finding => finding(self),
            frames => frames(self),
            count => self.points.len(),
            resolution => self.resolution.to_string(),
            points => template::grid(first_rows(grid(self))),
            hit_rates => rates.collect::<Vec<_>>(),
            plots => template::plots(plots, &()),
        };
        template::render("sweep.html", include_str!("page.html"), context).map(Some)
    }
}

/// The number of frames, in words: `3 frames (1 warms up)`.
pub(crate) fn frames(summary: &SweepSummary) -> String {
    let frames = counted(summary.frames.len(), "frame");
    match summary.warmup.len() {
        0 => frames,
        1 => format!("{frames} (1 warms up)"),
        warmup => format!("{frames} ({warmup} warm up)"),
    }
}

/// The finding of the sweep: the largest effect on cycles, in a sentence.
pub(crate) fn finding(summary: &SweepSummary) -> String {
    let mut found = [tornado::PLOT, heat_map::PLOT].into_iter().filter_map(|plot| (plot.figure)(summary));
    let title = found.next().map(|figure| figure.title).or_else(|| curves::finding_of_first(summary));
    title.map_or("Nothing was varied".into(), |title| format!("{title}."))
}

fn first_rows(mut table: Grid) -> Grid {
    table.rows.truncate(MOST_ROWS);
    table
}
