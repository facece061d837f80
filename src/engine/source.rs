//! What a machine takes from a stream, what can be wrong with it, and what is counted of it.

use crate::machine::layout::{Layout, OutOfRange};
use crate::stream::{Chunk, Decision, RayKind, Step, Totals};

/// What is wrong with a stream.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StreamFault {
    /// Items come in a wrong order.
    #[error("the stream has {found} where {expected} belongs")]
    Order {
        /// What came.
        found: &'static str,
        /// What belongs there.
        expected: &'static str,
    },
    /// A ray does not fit the format.
    #[error("ray {index} of a chunk {fault}")]
    Ray {
        /// The ray's place in its chunk.
        index: usize,
        /// What is wrong with it.
        fault: &'static str,
    },
    /// A step names something that is not there.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A packed step is of no kind.
    #[error("{0:#010x} is not a step")]
    NotAStep(u32),
}

/// A frame that is over, as counted by both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameCounts {
    /// The frame's number.
    pub frame: u32,
    /// What the tracer counted.
    pub tracer: Totals,
    /// What the machine replayed.
    pub machine: Totals,
    /// What it did otherwise than recorded.
    pub stores: StoreWork,
}

/// Steps of stores that a machine performed otherwise than recorded, so that both sides can be compared: reads are performed, merged or
/// raised; writes (updates included), recorded or added, are performed, merged, deferred or covered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoreWork {
    /// Reads that a register answered.
    pub merged_reads: u64,
    /// Writes that a register merged with one that waited.
    pub merged_writes: u64,
    /// Reads performed as updates: first touches.
    pub raised_reads: u64,
    /// Writes that are not recorded: of a sweep, and of first touches.
    pub added_writes: u64,
    /// Recorded writes of a frame's end that are left to first touches.
    pub deferred_writes: u64,
    /// Recorded writes of a frame's end that a sweep covers.
    pub covered_writes: u64,
    /// Updates that change nothing and were dropped at their rays.
    pub dropped_writes: u64,
    /// Reads that are not recorded: of learned bits at a frame's end.
    pub added_reads: u64,
    /// Updates that were merged with another of the same hit.
    pub gathered_writes: u64,
    /// Skipped shadow rays that the host answered.
    pub answered_rays: u64,
}

impl std::ops::AddAssign for StoreWork {
    fn add_assign(&mut self, other: Self) {
        self.merged_reads += other.merged_reads;
        self.merged_writes += other.merged_writes;
        self.raised_reads += other.raised_reads;
        self.added_writes += other.added_writes;
        self.deferred_writes += other.deferred_writes;
        self.covered_writes += other.covered_writes;
        self.dropped_writes += other.dropped_writes;
        self.added_reads += other.added_reads;
        self.gathered_writes += other.gathered_writes;
        self.answered_rays += other.answered_rays;
    }
}

/// The parent of every ray of a chunk, by its place; a primary ray is its own.
pub fn parents(chunk: &Chunk) -> Result<Vec<u32>, StreamFault> {
    let mut group = None;
    let parent = |(index, ray): (usize, crate::stream::Ray<'_>)| {
        let fault = |fault| StreamFault::Ray { index, fault };
        let primary = ray.head.kind == RayKind::Primary;
        if primary {
            group = Some(index as u32);
        }
        let Some(group) = group else { return Err(fault("comes before the first primary ray")) };
        if primary != (ray.head.parent == 0) {
            return Err(fault("is a primary ray with a parent, or another ray without one"));
        }
        let parent = (index as u32).checked_sub(ray.head.parent).filter(|&parent| parent >= group);
        if ray.head.decision == Decision::Skip && (ray.head.kind != RayKind::Shadow || !ray.packed_path().is_empty()) {
            return Err(fault("is skipped, but is no shadow ray or has a path"));
        }
        parent.ok_or_else(|| fault("has a parent outside its pixel group"))
    };
    chunk.rays().enumerate().map(parent).collect()
}

/// The step that `word` stands for, if it is one and what it names exists.
#[inline]
pub fn check_step(word: u32, layout: &Layout) -> Result<Step, StreamFault> {
    let step = Step::unpack(word).ok_or(StreamFault::NotAStep(word))?;
    layout.check(step)?;
    Ok(step)
}
