//! The rows as `results.parquet`: the columns of `results.csv`, with types. An empty field is null.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

use super::columns::{Column, NAMES, Of, VALUES};
use super::row::{Amount, Row};
use crate::report::error::ReportError;
use crate::report::writer::ReportFile;

/// The name of the file.
const PARQUET_FILE: &str = "results.parquet";

/// Rows of a row group.
const GROUP_ROWS: usize = 1 << 17;

/// A writer of rows.
pub(super) struct ParquetRows {
    writer: SerializedFileWriter<Vec<u8>>,
    columns: Vec<Values>,
    rows: usize,
}

/// The values of a column for the current row group, and for every row whether it has a value.
enum Values {
    Text(Filled<ByteArrayType>),
    Frame(Filled<Int64Type>),
    Number(Filled<DoubleType>),
}

struct Filled<T: DataType> {
    values: Vec<T::T>,
    present: Vec<i16>,
}

impl<T: DataType> Default for Filled<T> {
    fn default() -> Self {
        Self { values: Vec::new(), present: Vec::new() }
    }
}

impl Filled<ByteArrayType> {
    fn push_text(&mut self, text: &str) {
        self.push((!text.is_empty()).then(|| ByteArray::from(text)));
    }
}

impl<T: DataType> Filled<T> {
    fn push(&mut self, value: Option<T::T>) {
        self.present.push(i16::from(value.is_some()));
        self.values.extend(value);
    }

    fn write(&mut self, column: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        column.typed::<T>().write_batch(&self.values, Some(&self.present), None)?;
        *self = Self::default();
        Ok(())
    }
}

fn failed(source: ParquetError) -> ReportError {
    ReportError::Parquet { file: PARQUET_FILE, source }
}

impl ParquetRows {
    /// A file without rows, with a column for each varied field.
    pub(super) fn new(varied: &[&str]) -> Result<Self, ReportError> {
        Self::with_columns(varied).map_err(failed)
    }

    fn with_columns(varied: &[&str]) -> Result<Self, ParquetError> {
        let text = Of::Text(|_| "");
        let declared = |columns: &'static [Column]| columns.iter().map(|column| (column.name, &column.of));
        let varied = varied.iter().map(|field| (*field, &text));
        let all = declared(&NAMES).chain(varied).chain(declared(&VALUES));
        let (types, columns): (Vec<_>, Vec<_>) = all.map(|(name, of)| column(name, of)).unzip();
        let fields = types.into_iter().collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("results").with_fields(fields).build()?;
        let writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(WriterProperties::default()))?;
        Ok(Self { writer, columns, rows: 0 })
    }

    /// Adds a row.
    pub(super) fn add(&mut self, row: &Row<'_>) -> Result<(), ReportError> {
        let mut columns = self.columns.iter_mut();
        let mut put = |value: &dyn Fn(&mut Values)| columns.next().into_iter().for_each(value);
        NAMES.iter().for_each(|column| put(&|values| values.push(&column.of, row)));
        for value in row.of.varied {
            put(&|values| values.push_varied(*value));
        }
        VALUES.iter().for_each(|column| put(&|values| values.push(&column.of, row)));
        self.rows += 1;
        if self.rows == GROUP_ROWS { self.write_group().map_err(failed) } else { Ok(()) }
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for values in &mut self.columns {
            let Some(mut column) = group.next_column()? else { break };
            match values {
                Values::Text(filled) => filled.write(&mut column)?,
                Values::Frame(filled) => filled.write(&mut column)?,
                Values::Number(filled) => filled.write(&mut column)?,
            }
            column.close()?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }

    /// The whole file.
    pub(super) fn file(mut self) -> Result<ReportFile, ReportError> {
        if self.rows > 0 {
            self.write_group().map_err(failed)?;
        }
        Ok((PARQUET_FILE.into(), self.writer.into_inner().map_err(failed)?))
    }
}

impl Values {
    fn push(&mut self, of: &Of, row: &Row<'_>) {
        match (self, of) {
            (Self::Text(filled), Of::Text(of)) => filled.push_text(of(row)),
            (Self::Frame(filled), Of::Frame(of)) => filled.push(of(row).map(i64::from)),
            (Self::Number(filled), Of::Number(of)) => filled.push(of(row).map(Amount::as_f64)),
            _ => unreachable!("a column's values are of the column's type"),
        }
    }

    fn push_varied(&mut self, value: Option<&str>) {
        if let Self::Text(filled) = self {
            filled.push_text(value.unwrap_or_default());
        }
    }
}

/// The type of a column and the place of its values.
fn column(name: &str, of: &Of) -> (Result<TypePtr, ParquetError>, Values) {
    let (physical, logical, values) = match of {
        Of::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String), Values::Text(Filled::default())),
        Of::Frame(_) => (Physical::INT64, None, Values::Frame(Filled::default())),
        Of::Number(_) => (Physical::DOUBLE, None, Values::Number(Filled::default())),
    };
    let column = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
    (column.with_logical_type(logical).build().map(Arc::new), values)
}
