//! What can be wrong with the bytes of a ray stream file.

use super::step::Step;

/// What is wrong with the bytes of a place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The checksum does not match the bytes.
    #[error("the checksum does not fit the bytes")]
    Checksum,
    /// The block's tag is unknown.
    #[error("a block cannot begin with `{}`", found.escape_ascii())]
    Tag {
        /// The tag.
        found: [u8; 4],
    },
    /// The block's number is not the next number.
    #[error("block {found} is where block {expected} belongs")]
    Number {
        /// The block's number.
        found: u64,
        /// The next number.
        expected: u64,
    },
    /// A length exceeds the available space.
    #[error("a length of {found} bytes is stated where at most {limit} are possible")]
    TooLarge {
        /// The stated length.
        found: u64,
        /// The largest possible length.
        limit: u64,
    },
    /// The payload is no LZ4 block of the stated length.
    #[error("the payload cannot be unpacked to the {raw} bytes that are stated")]
    Compression {
        /// The stated length.
        raw: usize,
    },
    /// The payload's length does not fit its contents.
    #[error("the payload has {found} bytes where {expected} belong")]
    Length {
        /// The length.
        found: usize,
        /// The length that the payload's contents imply.
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
    /// The lengths of the rays' steps do not add up to the chunk's number of steps.
    #[error("the rays' steps are not {steps} in all")]
    Steps {
        /// The steps of the chunk.
        steps: usize,
    },
    /// A packed word of a file of version 2 is no step.
    #[error("{word:#010x} is no step of version 2")]
    OldStep {
        /// The packed word.
        word: u32,
    },
    /// A packed step of a file of version 2 has an id above [`Step::MAX_INDEX`].
    #[error("a step of version 2 names id {id}: ids up to {} can be replayed", Step::MAX_INDEX)]
    OldId {
        /// The id.
        id: u32,
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
        /// The value in the index.
        index: u64,
        /// The value in the file.
        found: u64,
    },
    /// The footer does not point to the index.
    #[error("the index cannot be at byte {offset}")]
    Offset {
        /// The offset that the footer states.
        offset: u64,
    },
}
