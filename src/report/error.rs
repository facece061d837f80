//! Errors of writing, reading and drawing reports.

use std::io;
use std::path::PathBuf;

use super::draw::DrawError;
use crate::output::FolderError;

/// Why a report cannot be written, read or drawn.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ReportError {
    /// A file or folder cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The file is no summary of a report.
    #[error("{} is not the summary of a report of `umbrasim run`, which is what is read here", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: serde_json::Error,
    },
    /// The file is no table of a run.
    #[error("{} is not a table of this report", path.display())]
    BrokenTable {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: csv::Error,
    },
    /// The summary has another schema version.
    #[error("{} has schema {found}; this version reads schema {schema}: run the experiment again", path.display())]
    Schema {
        /// The file.
        path: PathBuf,
        /// The version in the file.
        found: String,
        /// The version that can be read.
        schema: u32,
    },
    /// The summary names a picture outside the report.
    #[error("{}: the picture `{file}` is not inside the report", path.display())]
    Outside {
        /// The summary.
        path: PathBuf,
        /// The picture's path.
        file: String,
    },
    /// A picture cannot be encoded.
    #[error("cannot make the picture {file}")]
    Picture {
        /// Its file.
        file: String,
        /// The cause.
        source: png::EncodingError,
    },
    /// Numbers cannot be serialized.
    #[error("cannot make {file}")]
    Numbers {
        /// The file for the numbers.
        file: &'static str,
        /// The cause.
        source: serde_json::Error,
    },
    /// A table cannot be made.
    #[error("cannot make {file}")]
    Table {
        /// Its file.
        file: &'static str,
        /// The cause.
        source: csv::Error,
    },
    /// Rows cannot be written as Parquet.
    #[cfg(feature = "parquet")]
    #[error("cannot make {file}")]
    Parquet {
        /// The file.
        file: &'static str,
        /// The cause.
        source: parquet::errors::ParquetError,
    },
    /// A plot cannot be made.
    #[error("cannot make the plots")]
    Plot(#[from] DrawError),
    /// The page cannot be made.
    #[error("cannot make index.html")]
    Page(#[from] minijinja::Error),
}
