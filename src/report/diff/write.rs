//! The files of a comparison of two reports.

use minijinja::context;
use serde::Serialize;

use super::data::Diff;
use super::plot;
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::template;
use crate::report::writer::Report;

const PLOTS: &[Plot<Diff>] = &[plot::PLOT];

impl Report for Diff {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        let value = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let row = |it: &super::figures::Figure| {
            let [a, b] = it.values();
            vec![it.name().to_owned(), value(a), value(b), value(it.change())]
        };
        let rows = self.figures.iter().map(row).collect();
        vec![CsvTable::new("diff.csv", ["figure", "a", "b", "change"], rows)]
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let [a, b] = &self.folders;
        let context = context! {
            a => a.as_str(),
            b => b.as_str(),
            finding => self.verdict(),
            plots => template::plots(plots, &()),
            config => template::grid(self.config_grid()),
            found => template::grid(self.figures_grid()),
        };
        template::render("diff.html", include_str!("page.html"), context).map(Some)
    }
}
