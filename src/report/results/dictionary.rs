//! The meanings of the columns and metrics of `results.csv`.

use std::collections::BTreeMap;

use super::columns::{NAMES, VALUES, VARIED};
use super::names::Metric;
use crate::report::csv_table::CsvTable;
use crate::report::error::ReportError;
use crate::report::writer::ReportFile;

/// The name of the file.
const DICTIONARY_FILE: &str = "results.dictionary.csv";

/// The metrics of all rows, by name and path.
#[derive(Default)]
pub(super) struct Dictionary(BTreeMap<String, BTreeMap<String, Metric>>);

impl Dictionary {
    /// Adds the metric of a row. There are millions of rows and few metrics: a known metric costs no allocation.
    pub(super) fn add(&mut self, metric: &Metric) {
        let is_known = self.0.get(&metric.name).is_some_and(|paths| paths.contains_key(&metric.path));
        if !is_known {
            self.0.entry(metric.name.clone()).or_default().insert(metric.path.clone(), metric.clone());
        }
    }

    /// The file: one row per column, in order, then one per metric. A metric of totals and of frames has two rows.
    pub(super) fn file(&self, varied: &[&str]) -> Result<ReportFile, ReportError> {
        let row = |cells: [&str; 5]| cells.map(str::to_owned).to_vec();
        let column = |name, about| row(["column", name, "", about, ""]);
        let columns = NAMES.iter().map(|it| column(it.name, it.about));
        let columns = columns.chain(varied.iter().map(|field| column(field, VARIED)));
        let columns = columns.chain(VALUES.iter().map(|it| column(it.name, it.about)));
        let metrics =
            self.0.values().flat_map(BTreeMap::values).map(|it| row(["metric", &it.name, it.unit, it.about, &it.path]));
        let head = ["entry", "name", "unit", "meaning", "path_in_summary"];
        let table = CsvTable::new(DICTIONARY_FILE, head, columns.chain(metrics).collect());
        Ok((DICTIONARY_FILE.into(), table.bytes()?))
    }
}
