//! What can be wrong with a ray stream file.

use std::fmt;
use std::path::PathBuf;

use super::fault::Fault;
use super::violation::Violation;

/// Why a stream cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// The operating system reported an error.
    #[error("cannot {doing} {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The operation that failed.
        doing: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no ray stream.
    #[error("{} is no ray stream: {found}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is there instead.
        found: String,
    },
    /// The file is of another version of the format.
    #[error(
        "{} is a ray stream of version {found}; this program reads versions 2 and 3: record it again", path.display()
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// The file's version.
        found: u32,
    },
    /// The file ends too early.
    #[error("{} is cut off: {missing}", path.display())]
    CutOff {
        /// The file.
        path: PathBuf,
        /// The missing part.
        missing: &'static str,
    },
    /// Bytes of the file were changed, or it was put together wrongly.
    #[error("{} is corrupt: {place}: {fault}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// The place in the file.
        place: Place,
        /// What is wrong.
        fault: Fault,
    },
    /// The bytes are intact, but their contents break a rule of ray streams.
    #[error("{} is not valid: {place}: {violation}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The place in the file.
        place: Place,
        /// The broken rule.
        violation: Violation,
    },
    /// The writer failed before: its file cannot be completed.
    #[error("{} cannot be completed: an earlier write to it failed", path.display())]
    Failed {
        /// The file.
        path: PathBuf,
    },
}

/// A place in a stream file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The header.
    Header,
    /// A block.
    Block {
        /// The number of the frame that the block is in, if it is in one.
        frame: Option<u32>,
        /// The block's place among the file's blocks.
        block: u64,
    },
    /// The index of frames.
    Index,
    /// The footer.
    Footer,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header => write!(f, "header"),
            Self::Block { frame: Some(frame), block } => write!(f, "frame {frame}, block {block}"),
            Self::Block { frame: None, block } => write!(f, "block {block}"),
            Self::Index => write!(f, "index"),
            Self::Footer => write!(f, "footer"),
        }
    }
}
