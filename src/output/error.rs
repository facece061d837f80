//! Why results cannot be put into a folder.

use std::io;
use std::path::PathBuf;

/// Why results cannot be put into a folder.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// Something that is no folder of results is in the way.
    #[error("{} is not an umbrasim report (it has no list of a report's files) and will not be overwritten", path.display())]
    Foreign {
        /// What is in the way.
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
    /// A file that is not the report's has the name of one that is.
    #[error("{} is not of the earlier report and will not be overwritten", path.display())]
    Collision {
        /// The file.
        path: PathBuf,
    },
    /// The folder is the one in which the command runs, or holds it.
    #[error("{} cannot be replaced while the command runs in it: name another folder, or run from outside", path.display())]
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
    /// The results are complete and cannot take their place.
    #[error("{source}; the new report is in {}", path.display())]
    Elsewhere {
        /// Where the results are.
        path: PathBuf,
        /// Why they are not in their place.
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
