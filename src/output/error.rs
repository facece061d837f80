//! Why results cannot be put into a folder.

use std::io;
use std::path::PathBuf;

/// Why results cannot be put into a folder.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// Something other than a folder of results is at the path.
    #[error(
        "{} is not an umbrasim report (it has no list of a report's files) and will not be overwritten", path.display()
    )]
    Foreign {
        /// The path.
        path: PathBuf,
    },
    /// Another process writes there.
    #[error("{} is being written by {holder}", path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
        /// The process, its machine, and since when.
        holder: String,
    },
    /// A foreign file has the name of one of the report's files.
    #[error("{} is not of the earlier report and will not be overwritten", path.display())]
    Collision {
        /// The file.
        path: PathBuf,
    },
    /// The command runs in the folder, or in a folder inside it.
    #[error(
        "{} cannot be replaced while the command runs in it: name another folder, or run from outside", path.display()
    )]
    Current {
        /// The folder.
        path: PathBuf,
    },
    /// The folder is the root of a file system, which nothing can replace.
    #[error("{} is where a file system is mounted and cannot be replaced: name a folder in it", path.display())]
    Mounted {
        /// The folder.
        path: PathBuf,
    },
    /// The results are complete, but cannot be put at their path.
    #[error("{source}; the new report is in {}", path.display())]
    Elsewhere {
        /// Where the results are.
        path: PathBuf,
        /// Why they are not at their path.
        source: Box<FolderError>,
    },
    /// Something cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Something cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}
