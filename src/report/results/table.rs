//! The rows as files.

use super::Results;
use super::dictionary::Dictionary;
use super::row::Row;
use crate::report::csv_table::cell;
use crate::report::error::ReportError;
use crate::report::writer::ReportFile;

/// The file of the rows.
pub(super) const RESULTS_FILE: &str = "results.csv";

/// Columns in front of the varied fields, each with what it holds.
pub(super) const NAMES: [(&str, &str); 7] = [
    ("run", "name of the experiment"),
    ("scene", "name of the scene"),
    (
        "scope",
        "total: all measured frames together (of rows without a machine, all traced frames); \
         frame: one frame; warmup: one frame that is in no total, since it warms the machine up",
    ),
    ("frame", "number of the frame; empty of totals"),
    ("policy", "name of the culling policy"),
    ("machine", "name of the machine; empty of what the tracer counted"),
    ("fidelity", "fidelity level that the machine was replayed at; empty of what the tracer counted"),
];

/// Columns behind the varied fields.
pub(super) const MEASURES: [(&str, &str); 6] = [
    ("part", "level of memory, cache, unit, queue, kind of rays, part with energy, or light; empty of a whole machine"),
    (
        "class",
        "class of memory traffic, or cause of a unit's cycles; of split.cycles and split.dram which of three replays",
    ),
    ("metric", "what the number is: see the rows of this file whose entry is metric"),
    ("value", "the number"),
    ("unit", "unit of value and half_width"),
    (
        "half_width",
        "half the width of the number's 95 % interval: 0 of an exact number, empty where the interval is not known",
    ),
];

/// What a varied field holds.
pub(super) const VARIED: &str = "varied field of the machine's file; empty where the value is the file's own";

/// `results.csv`, its dictionary, and what else holds the rows.
///
/// # Errors
/// A number has no form in the files.
pub(in crate::report) fn files(results: &impl Results) -> Result<Vec<ReportFile>, ReportError> {
    let mut table = CsvRows::new(results)?;
    let mut dictionary = Dictionary::default();
    results.rows(&mut |row| {
        dictionary.add(row.metric);
        table.add(row)
    })?;
    Ok(vec![(RESULTS_FILE.into(), table.bytes()?), dictionary.file(&results.varied())?])
}

/// The rows as CSV.
struct CsvRows<'a> {
    run: &'a str,
    scene: &'a str,
    csv: csv::Writer<Vec<u8>>,
}

fn failed(source: csv::Error) -> ReportError {
    ReportError::Table { file: RESULTS_FILE, source }
}

impl<'a> CsvRows<'a> {
    fn new(results: &'a impl Results) -> Result<Self, ReportError> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        let head = NAMES.iter().map(|(name, _)| *name).chain(results.varied());
        csv.write_record(head.chain(MEASURES.iter().map(|(name, _)| *name))).map_err(failed)?;
        Ok(Self { run: results.run(), scene: results.scene(), csv })
    }

    fn add(&mut self, row: &Row<'_>) -> Result<(), ReportError> {
        let (machine, fidelity) = row.of.machine.unwrap_or_default();
        let frame = cell(row.of.frame);
        let names = [self.run, self.scene, row.of.scope.name(), &frame, row.of.policy, machine, fidelity];
        let varied = row.of.varied.iter().map(|value| value.unwrap_or_default());
        let (value, half_width) = (row.value.to_string(), cell(row.half_width));
        let [part, class] = [row.part, row.class].map(Option::unwrap_or_default);
        let measures = [part, class, &row.metric.name, &value, row.metric.unit, &half_width];
        self.csv.write_record(names.into_iter().chain(varied).chain(measures)).map_err(failed)
    }

    fn bytes(self) -> Result<Vec<u8>, ReportError> {
        self.csv.into_inner().map_err(|error| failed(error.into_error().into()))
    }
}
