//! The files of a report on predictions.

use minijinja::context;
use serde::Serialize;

use super::data::{Extrapolation, Extrapolations, Told};
use super::plot;
use super::words::{grid, verdict};
use crate::report::csv_table::{CsvTable, cell};
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::template;
use crate::report::writer::Report;

const PLOTS: &[Plot<Extrapolations>] = &[plot::PLOT];

/// Columns of `extrapolate.csv`. Each figure of a machine has a row per model, one for the prediction, and one for
/// `Event`.
const COLUMNS: [&str; 11] =
    ["scene", "policy", "machine", "cores", "figure", "unit", "of", "model_cores", "value", "low", "high"];

/// The rows of a machine.
fn rows(found: &Extrapolation) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for Told { key, unit, models, predicted, truth, .. } in found.told() {
        let mut row = |of: &str, cores: Option<u64>, value: f64, range: Option<[f64; 2]>| {
            let names = [&found.scene, &found.policy, &found.machine].map(String::clone);
            let numbers = [cell(cores), value.to_string(), cell(range.map(|it| it[0])), cell(range.map(|it| it[1]))];
            let figure = [found.cores.to_string(), key.into(), unit.name().into(), of.into()];
            rows.push(names.into_iter().chain(figure).chain(numbers).collect());
        };
        models.iter().for_each(|&(cores, value)| row("model", Some(cores), value, None));
        row("predicted", None, predicted.value, Some([predicted.low, predicted.high]));
        truth.into_iter().for_each(|truth| row("Event", None, truth, None));
    }
    rows
}

impl Report for Extrapolations {
    type Section = ();

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        vec![CsvTable::new("extrapolate.csv", COLUMNS, self.0.iter().flat_map(rows).collect())]
    }

    fn plots(&self) -> Result<Vec<Drawing>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing]) -> Result<Option<String>, minijinja::Error> {
        let machine = |found: &Extrapolation| {
            let lines: Vec<String> = verdict(found).lines().map(String::from).collect();
            context! { name => found.name(), lines, table => template::grid(grid(found)) }
        };
        let first = self.0.first();
        let context = context! {
            plots => template::plots(plots, &()),
            finding => plot::finding(&self.0),
            scene => first.map(|found| found.scene.as_str()),
            policy => first.map(|found| found.policy.as_str()),
            fidelity => first.map(|found| found.fidelity.as_str()),
            machines => self.0.iter().map(machine).collect::<Vec<_>>(),
        };
        template::render("extrapolate.html", include_str!("page.html"), context).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::ResultsFolder;
    use crate::report::extrapolate::{Figures, Prediction, ScaleModel};
    use crate::report::writer::{SUMMARY_FILE, write};

    fn of(cores: u64, checked: Option<u64>) -> Extrapolation {
        let told = |value| Prediction { value, low: 0.5 * value, high: 1.5 * value, least: 0 };
        let model = |cores| ScaleModel {
            cores,
            rays: 100,
            figures: Figures { cycles: 1000.0, l2_bytes: 2000.0, dram_bytes: 0.0 },
            joules: Some(2e-6),
        };
        Extrapolation {
            scene: "room".into(),
            policy: "Off".into(),
            machine: "small".into(),
            cores,
            dram: "1 channel".into(),
            fidelity: "Event".into(),
            rays: 1000,
            rays_an_entry: 40.0,
            rays_per_second: 1e8,
            models: vec![model(1), model(2)],
            predicted: Figures { cycles: told(900.0), l2_bytes: told(2000.0), dram_bytes: told(0.0) },
            joules: Some(told(1e-6)),
            checked: checked.map(|cycles| Figures { cycles, l2_bytes: 2000, dram_bytes: 0 }),
            checked_joules: checked.map(|_| 1e-6),
        }
    }

    #[test]
    fn a_page_has_each_machine_and_a_row_is_a_figure() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("it");
        let found = Extrapolations(vec![of(4, Some(1000)), of(8, None)]);
        let page = write(&ResultsFolder::claim(&target).unwrap(), &found).unwrap();
        let page = std::fs::read_to_string(page).unwrap();
        for part in ["<svg", "small, 8 cores", "at most 10", "DRAM bytes: none"] {
            assert!(page.contains(part), "{part}: {page}");
        }
        let read = |file: &str| std::fs::read_to_string(target.join(file)).unwrap();
        assert_eq!(serde_json::from_str::<Extrapolations>(&read(SUMMARY_FILE)).unwrap(), found);
        let table = read("extrapolate.csv");
        assert_eq!(table.lines().count(), 1 + 4 * (2 + 1 + 1) + 4 * (2 + 1), "{table}");
        for row in
            ["cycles,cycles,predicted,,900,450,1350", "energy,J,model,2,0.000002,,", "l2_bytes,bytes,Event,,2000,,"]
        {
            assert!(table.contains(&format!("\nroom,Off,small,4,{row}\n")), "{row}: {table}");
        }
        assert!(plot::finding(&found.0[..1]).ends_with("900 cycles, 10.0 % fewer than by Event"));
    }
}
