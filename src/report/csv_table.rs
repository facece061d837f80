//! Tables as CSV files.

use super::error::ReportError;

/// The content of a CSV file.
pub(crate) struct CsvTable {
    /// The file's name.
    pub file: &'static str,
    /// Headers.
    pub head: Vec<String>,
    /// Rows, each as long as `head`.
    pub rows: Vec<Vec<String>>,
}

impl CsvTable {
    /// A table of columns with these headers.
    pub(crate) fn new<'a>(file: &'static str, head: impl IntoIterator<Item = &'a str>, rows: Vec<Vec<String>>) -> Self {
        Self { file, head: head.into_iter().map(Into::into).collect(), rows }
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// A row is not as long as the headers.
    pub(crate) fn bytes(&self) -> Result<Vec<u8>, ReportError> {
        let failed = |source| ReportError::Table { file: self.file, source };
        let mut csv = csv::Writer::from_writer(Vec::new());
        std::iter::once(&self.head).chain(&self.rows).try_for_each(|row| csv.write_record(row)).map_err(failed)?;
        csv.into_inner().map_err(|error| failed(error.into_error().into()))
    }
}

/// A cell's text: empty where there is no value.
pub(super) fn cell<T: ToString>(value: Option<T>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}
