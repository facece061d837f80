//! The rows as files.

use super::columns::{Column, NAMES, Of, RESULTS_FILE, VALUES};
use super::dictionary::Dictionary;
#[cfg(feature = "parquet")]
use super::parquet::ParquetRows;
use super::row::{Results, Row};
use crate::report::csv_table::cell;
use crate::report::error::ReportError;
use crate::report::writer::ReportFile;

/// `results.csv`, its dictionary, and with the feature `parquet` the same rows in `results.parquet`.
///
/// # Errors
/// A number cannot be represented in the files.
pub(in crate::report) fn files(results: &impl Results) -> Result<Vec<ReportFile>, ReportError> {
    let varied = results.varied();
    let mut csv = CsvRows::new(&varied)?;
    #[cfg(feature = "parquet")]
    let mut parquet = ParquetRows::new(&varied)?;
    let mut dictionary = Dictionary::default();
    results.rows(&mut |row| {
        dictionary.add(row.metric);
        #[cfg(feature = "parquet")]
        parquet.add(row)?;
        csv.add(row)
    })?;
    Ok(vec![
        (RESULTS_FILE.into(), csv.bytes()?),
        #[cfg(feature = "parquet")]
        parquet.file()?,
        dictionary.file(&varied)?,
    ])
}

/// The rows as CSV.
struct CsvRows(csv::Writer<Vec<u8>>);

fn failed(source: csv::Error) -> ReportError {
    ReportError::Table { file: RESULTS_FILE, source }
}

impl CsvRows {
    fn new(varied: &[&str]) -> Result<Self, ReportError> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        let names = |columns: &'static [Column]| columns.iter().map(|column| column.name);
        csv.write_record(names(&NAMES).chain(varied.iter().copied()).chain(names(&VALUES))).map_err(failed)?;
        Ok(Self(csv))
    }

    fn add(&mut self, row: &Row<'_>) -> Result<(), ReportError> {
        NAMES.iter().try_for_each(|column| self.put(column, row))?;
        row.of.varied.iter().try_for_each(|value| self.0.write_field(value.unwrap_or_default())).map_err(failed)?;
        VALUES.iter().try_for_each(|column| self.put(column, row))?;
        self.0.write_record(None::<&[u8]>).map_err(failed)
    }

    fn put(&mut self, column: &Column, row: &Row<'_>) -> Result<(), ReportError> {
        let written = match column.of {
            Of::Text(of) => self.0.write_field(of(row)),
            Of::Frame(of) => self.0.write_field(cell(of(row))),
            Of::Number(of) => self.0.write_field(cell(of(row))),
        };
        written.map_err(failed)
    }

    fn bytes(self) -> Result<Vec<u8>, ReportError> {
        self.0.into_inner().map_err(|error| failed(error.into_error().into()))
    }
}
