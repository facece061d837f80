//! The files of a failure map.

use minijinja::context;
use serde::Serialize;

use super::data::{Figure, LadderMap, grid};
use super::plot;
use crate::report::csv_table::{CsvTable, cell};
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::template;
use crate::report::writer::Report;

const PLOTS: &[Plot<LadderMap>] = &[plot::PLOT];

/// Columns of `ladder.csv`: one row per point, level and figure.
const COLUMNS: [&str; 8] =
    ["axis", "value", "event_cycles", "rung", "figure", "error", "intervals_that_hold", "intervals"];

impl Report for LadderMap {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        let mut rows = Vec::new();
        for axis in &self.axes {
            for point in &axis.points {
                for (name, row) in self.rows.iter().zip(&point.rows) {
                    for figure in Figure::ALL {
                        let Some(error) = row.errors[figure as usize] else { continue };
                        let covered = row.covered.filter(|_| figure == Figure::Cycles);
                        rows.push(vec![
                            axis.name.clone(),
                            point.value.clone(),
                            point.cycles.0.to_string(),
                            name.clone(),
                            figure.name().into(),
                            error.to_string(),
                            cell(covered.map(|covered| covered.held)),
                            cell(covered.map(|covered| covered.told)),
                        ]);
                    }
                }
            }
        }
        vec![CsvTable::new("ladder.csv", COLUMNS, rows)]
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let context = context! { plots => template::plots(plots, &()), worst => template::grid(grid(self)) };
        template::render("ladder.html", include_str!("page.html"), context).map(Some)
    }
}
