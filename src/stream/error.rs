//! What can be wrong with a ray stream file.

use std::fmt;
use std::path::PathBuf;

use super::check::Violation;

/// Why a stream cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// The system refused.
    #[error("cannot {doing} {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        doing: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// A stream replaces its target as a whole, which a device, a pipe or a folder does not allow.
    #[error("{} is there and is no regular file: a ray stream cannot be written to it", path.display())]
    NotAFile {
        /// The target.
        path: PathBuf,
    },
    /// The file is something else.
    #[error("{} is no ray stream: {found}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is there instead.
        found: String,
    },
    /// The file is of another version of the format.
    #[error("{} is a ray stream of version {found}; this program reads version {known}: record it again", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// The file's version.
        found: u32,
        /// The version that can be read.
        known: u32,
    },
    /// The file ends too early.
    #[error("{} is cut off: {missing}", path.display())]
    CutOff {
        /// The file.
        path: PathBuf,
        /// What is not there.
        missing: &'static str,
    },
    /// Bytes of the file were changed, or it was put together wrongly.
    #[error("{} is corrupt: {place}: {fault}", path.display())]
    Corrupt {
        /// The file.
        path: PathBuf,
        /// Where.
        place: Place,
        /// What is wrong.
        fault: Fault,
    },
    /// The bytes are whole, but what they say breaks a rule of ray streams.
    #[error("{} is not valid: {place}: {violation}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Where.
        place: Place,
        /// The rule.
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

/// What is wrong with the bytes of a place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The checksum is not that of the bytes.
    #[error("the checksum does not fit the bytes")]
    Checksum,
    /// The block's tag is unknown.
    #[error("a block cannot begin with `{}`", found.escape_ascii())]
    Tag {
        /// The tag.
        found: [u8; 4],
    },
    /// The block is not the one that follows.
    #[error("block {found} is where block {expected} belongs")]
    Number {
        /// The block's number.
        found: u64,
        /// The number that follows.
        expected: u64,
    },
    /// A length is more than can be there.
    #[error("a length of {found} bytes is stated where at most {limit} are possible")]
    TooLarge {
        /// The stated length.
        found: u64,
        /// The largest that is possible.
        limit: u64,
    },
    /// The payload is no LZ4 block of the stated length.
    #[error("the payload cannot be unpacked to the {raw} bytes that are stated")]
    Compression {
        /// The stated length.
        raw: usize,
    },
    /// The payload's length is not that of its contents.
    #[error("the payload has {found} bytes where {expected} belong")]
    Length {
        /// The length.
        found: usize,
        /// The length that follows from what the payload says.
        expected: usize,
    },
    /// A ray's byte of kind, decision and outcome is unknown, or names a primitive without a hit.
    #[error("ray {ray}: {class:#04x} with primitive {primitive} is no kind, decision and outcome")]
    Class {
        /// The ray's place in its chunk.
        ray: usize,
        /// The byte.
        class: u8,
        /// The primitive.
        primitive: u32,
    },
    /// The rays' steps are not as many as the chunk's.
    #[error("the rays' steps are not {steps} in all")]
    Steps {
        /// The steps of the chunk.
        steps: usize,
    },
    /// The header's text cannot be read.
    #[error("{0}")]
    Header(String),
    /// A block of the index stands where a frame's block belongs, or the other way round.
    #[error("a block of the wrong kind")]
    Kind,
    /// The index does not fit the file.
    #[error("frame {frame}: the index says {what} is {index}, and it is {found}")]
    Index {
        /// The frame's number.
        frame: u32,
        /// What differs.
        what: &'static str,
        /// What the index says.
        index: u64,
        /// What the file says.
        found: u64,
    },
    /// The footer does not point to the index.
    #[error("the index cannot be at byte {offset}")]
    Offset {
        /// Where the footer points to.
        offset: u64,
    },
}
