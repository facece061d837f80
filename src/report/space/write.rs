//! The files of a space's report.

use minijinja::context;
use serde::Serialize;

use super::data::{Design, SpaceSummary};
use super::{front, predicted, sensitivity};
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::error::ReportError;
use crate::report::format::counted;
use crate::report::results;
use crate::report::template;
use crate::report::writer::{Report, ReportFile};

const PLOTS: &[Plot<SpaceSummary>] =
    &[front::PLOT, sensitivity::CYCLES, sensitivity::DRAM_BYTES, sensitivity::ENERGY, predicted::PLOT];

/// The most rows of a table on the page; the CSV has all.
const MOST_ROWS: usize = 1_000;

impl Report for SpaceSummary {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        let fields = self.fields();
        let own =
            ["design", "machine", "policy", "replayed", "front", "cycles", "dram_bytes", "joules", "wrong_pixels"];
        let widths = ["cycles_half_width", "dram_bytes_half_width", "joules_half_width"];
        let head = own.into_iter().chain(widths).chain(fields.iter().copied());
        let row = |(number, it): (usize, &Design)| {
            let truth = |it: bool| if it { "1" } else { "0" }.to_owned();
            let half = |figure: &str| it.half_widths.get(figure).map_or_else(String::new, f64::to_string);
            let mut row = vec![(number + 1).to_string(), it.machine.clone(), it.policy.clone()];
            row.extend([truth(it.replayed), truth(it.front), it.cycles.to_string(), it.dram_bytes.to_string()]);
            row.push(it.joules.map_or_else(String::new, |joules| joules.to_string()));
            row.push(it.wrong_pixels.to_string());
            row.extend(["cycles", "dram_bytes", "joules"].map(half));
            row.extend(fields.iter().map(|field| it.value(field).unwrap_or_default().to_owned()));
            row
        };
        let rows = self.designs.iter().enumerate().map(row).collect();
        vec![CsvTable::new("space.csv", head, rows)]
    }

    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        results::files(self)
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let all: Vec<(usize, &Design)> = self.designs.iter().enumerate().take(MOST_ROWS).collect();
        let context = context! {
            experiment => self.experiment.as_str(),
            scene => self.scene.as_str(),
            finding => self.finding(),
            scope => self.scope(),
            fidelity => self.fidelity.as_str(),
            frames => counted(self.frames.len(), "frame"),
            resolution => self.resolution.to_string(),
            front => template::grid(self.front_grid(MOST_ROWS)),
            fields => template::grid(self.sensitivity_grid()),
            accuracy => template::grid(self.accuracy_grid()),
            designs => template::grid(self.grid(&all, true)),
            shown => all.len(),
            count => self.designs.len(),
            plots => template::plots(plots, &()),
        };
        template::render("space.html", include_str!("page.html"), context).map(Some)
    }
}
