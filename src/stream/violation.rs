//! The rules of a ray stream that can be broken.

use super::chunk::{Outcome, RayKind};
use super::step::Step;

/// A rule that a stream breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Violation {
    /// A number of the header exceeds its limit.
    #[error("{what}: {found}, and at most {limit} are possible")]
    Header {
        /// What is counted.
        what: &'static str,
        /// The number.
        found: u64,
        /// The largest possible.
        limit: u64,
    },
    /// The length of the table of triangle records is not the number of static primitives.
    #[error("records of {found} static primitives, and there are {primitives}")]
    Records {
        /// Entries of the table.
        found: usize,
        /// Static primitives.
        primitives: u32,
    },
    /// A static primitive's record does not exist, or belongs to another primitive.
    #[error("the triangle record of primitive {primitive} is {found}, which does not exist or is another's")]
    Record {
        /// The primitive.
        primitive: usize,
        /// The record.
        found: u32,
    },
    /// An item stands where another belongs: every frame is a beginning, any number of rays, and an end.
    #[error("{found} where {expected} belongs")]
    Order {
        /// The item that came.
        found: &'static str,
        /// The items that are allowed here.
        expected: &'static str,
    },
    /// A frame is not the next one in the header's list.
    #[error("frame {found} begins where the header lists frame {expected}")]
    Frame {
        /// The frame's number.
        found: u32,
        /// The number in the header.
        expected: u32,
    },
    /// The stream has more frames than the header lists.
    #[error("frame {found} begins, but the header lists no further frame")]
    ExtraFrame {
        /// The frame's number.
        found: u32,
    },
    /// The stream has fewer frames than the header lists.
    #[error("the stream ends, but the header lists frame {expected} as the next")]
    MissingFrame {
        /// The number of the first missing frame.
        expected: u32,
    },
    /// A block would be larger than the format allows.
    #[error("{what} of {found} bytes: at most {limit} fit a block; split it")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// Its length before compression, in bytes.
        found: u64,
        /// The largest length.
        limit: u64,
    },
    /// A ray breaks a rule.
    #[error("ray {ray} of the chunk: {fault}")]
    Ray {
        /// The ray's place in its chunk.
        ray: usize,
        /// The broken rule.
        fault: RayFault,
    },
    /// A step of the policy at the frame's end breaks a rule.
    #[error("the policy's work at the frame's end: {0}")]
    End(StepFault),
    /// A total of the tracer differs from the count of the records.
    #[error("{what} is {recorded} in the totals, and {counted} in the records")]
    Totals {
        /// The total's name.
        what: &'static str,
        /// The tracer's count.
        recorded: u64,
        /// The records' count.
        counted: u64,
    },
}

/// A rule that a ray breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RayFault {
    /// A chunk does not begin with a primary ray.
    #[error("the first ray of a chunk must be a primary ray")]
    FirstRay,
    /// A primary ray has a parent, or the parent of another ray is not in its pixel group.
    #[error("its parent, {0} rays back, is not in its pixel group")]
    Parent(u32),
    /// The parent has no hit for the ray to start on.
    #[error("its parent, {0} rays back, hits nothing")]
    ParentWithoutHit(u32),
    /// The pixel is not in the picture.
    #[error("pixel {found}, and there are {pixels}")]
    Pixel {
        /// The pixel.
        found: u32,
        /// The picture's pixels.
        pixels: u64,
    },
    /// The pixel is not that of the group's primary ray.
    #[error("pixel {found} in the group of pixel {group}")]
    OtherPixel {
        /// The pixel.
        found: u32,
        /// The pixel of the group.
        group: u32,
    },
    /// The light is not in the scene, or the ray is no shadow ray and has a light.
    #[error("light {found}, and it can have {lights}")]
    Light {
        /// The light.
        found: u8,
        /// Number of lights that the ray can name.
        lights: u32,
    },
    /// A ray other than a shadow ray is culled.
    #[error("only a shadow ray can be culled")]
    Decision,
    /// A skipped ray was traced.
    #[error("it is skipped, and yet its path has {0} steps")]
    SkippedPath(usize),
    /// The outcome is not possible for the ray's kind.
    #[error("the outcome {outcome:?} is not possible for a ray of kind {}", kind.name())]
    Outcome {
        /// The ray's kind.
        kind: RayKind,
        /// The outcome.
        outcome: Outcome,
    },
    /// The primitive that is hit is not in the scene.
    #[error("primitive {found} is hit, and there are {primitives}")]
    Primitive {
        /// The primitive.
        found: u32,
        /// Primitives of the scene.
        primitives: u32,
    },
    /// A step of the path breaks a rule.
    #[error("path: {0}")]
    Path(StepFault),
    /// A step of the policy breaks a rule.
    #[error("policy: {0}")]
    Policy(StepFault),
}

/// A rule that a step breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StepFault {
    /// The packed word is no step.
    #[error("step {at} is {word:#010x}, which is no step")]
    Unknown {
        /// The step's place.
        at: usize,
        /// The packed word.
        word: u32,
    },
    /// The step is not allowed here, or its id is too large.
    #[error("step {at} is {step:?}, and ids below {limit} are possible for it here")]
    Id {
        /// The step's place.
        at: usize,
        /// The step.
        step: Step,
        /// Ids below this are allowed; 0 for a step that is not allowed here.
        limit: u32,
    },
}
