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
    /// The experiment cannot be loaded.
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
    /// Points that a report needs are missing.
    #[error("{missing} of {of} points are missing. To make them:\n{}", commands.join("\n"))]
    Missing {
        /// The number of missing points.
        missing: usize,
        /// The number of points of the sweep.
        of: usize,
        /// Commands that make the missing points.
        commands: Vec<String>,
    },
    /// Points were made by another build of the program.
    #[error(
        "{points} of {of} points are of build {build}, such as {}, and this program is build {}: one report holds points \
         of one build. Collect with the program that made those points, or run the shards again with this one",
        path.display(), env!("UMBRASIM_BUILD")
    )]
    OtherBuild {
        /// The file of one of the points.
        path: PathBuf,
        /// The number of points of the other build.
        points: usize,
        /// The number of points of the sweep.
        of: usize,
        /// The other build.
        build: String,
    },
    /// Stopped: points that are done are kept.
    #[error("stopped; the points done are kept, and the same command goes on with the others")]
    Stopped,
    /// Stopped, by a command that keeps nothing.
    #[error("stopped; nothing was kept")]
    Dropped,
}
