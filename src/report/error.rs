//! Why a report cannot be written, read or drawn.

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
        /// What the system said.
        source: io::Error,
    },
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The file is no summary.
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
    /// The summary is of another version.
    #[error("{} has schema {found}; this version reads schema {schema}: run the experiment again", path.display())]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its version, as it stands there.
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
    /// A picture cannot be made.
    #[error("cannot make the picture {file}")]
    Picture {
        /// Its file.
        file: String,
        /// What is wrong with it.
        source: png::EncodingError,
    },
    /// Numbers cannot be put in words.
    #[error("cannot make {file}")]
    Numbers {
        /// The file that was to hold them.
        file: &'static str,
        /// Why not.
        source: serde_json::Error,
    },
    /// A table cannot be made.
    #[error("cannot make {file}")]
    Table {
        /// Its file.
        file: &'static str,
        /// Why not.
        source: csv::Error,
    },
    /// Rows cannot be written as Parquet.
    #[cfg(feature = "parquet")]
    #[error("cannot make {file}")]
    Parquet {
        /// The file.
        file: &'static str,
        /// Why not.
        source: parquet::errors::ParquetError,
    },
    /// A plot cannot be made.
    #[error("cannot make the plots")]
    Plot(#[from] DrawError),
    /// The page cannot be made.
    #[error("cannot make index.html")]
    Page(#[from] minijinja::Error),
}
