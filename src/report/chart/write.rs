//! The files of the chart.

use minijinja::context;
use serde::Serialize;

use super::data::ChartSummary;
use super::plot::{self, finding};
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::template;
use crate::report::writer::Report;

const PLOTS: &[Plot<ChartSummary>] = &[plot::PLOT];

impl Report for ChartSummary {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        Vec::new()
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let context = context! {
            plots => template::plots(plots, &()),
            finding => finding(self),
            experiments => self.experiments.clone(),
            points => template::grid(self.grid()),
        };
        template::render("chart.html", include_str!("page.html"), context).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::ResultsFolder;
    use crate::report::run::tests::sample;
    use crate::report::writer::{SUMMARY_FILE, write};

    #[test]
    fn the_page_holds_plot_and_table() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("chart");
        let chart = ChartSummary::new(&[sample::sample(&[0, 2]).summary]);
        let pages = [(); 2].map(|()| write(&ResultsFolder::claim(&target).unwrap(), &chart).unwrap());
        let text = std::fs::read(target.join(SUMMARY_FILE)).unwrap();
        assert_eq!(serde_json::from_slice::<ChartSummary>(&text).unwrap(), chart);
        let page = std::fs::read_to_string(&pages[1]).unwrap();
        for part in ["<svg", "last_occluder", "wrong a million"] {
            assert!(page.contains(part), "{part}");
        }
    }
}
