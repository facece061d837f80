//! Why a sweep ends without a result.

use std::path::PathBuf;

use super::super::load::ExperimentError;
use crate::output::FolderError;
use crate::replay::RunError;
use crate::ron_file::ConfigError;
use crate::stream::StreamError;

/// Why a sweep ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The experiment cannot be had.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// A config is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A stream cannot be written or read.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// The folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A replay failed.
    #[error("machine `{machine}` on the stream of `{policy}`")]
    Machine {
        /// The machine's name.
        machine: String,
        /// The policy.
        policy: String,
        /// What happened.
        source: Box<RunError>,
    },
    /// A file of the sweep cannot be read or written.
    #[error("cannot read or write {}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Stopped: what was done is kept.
    #[error("stopped; the points done are kept, and the same command goes on with the others")]
    Stopped,
}
