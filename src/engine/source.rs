//! Checks of a stream's items against a machine's layout, and the counts of a replayed frame.

use crate::counters::counters;
use crate::machine::layout::{Layout, OutOfRange};
use crate::stream::{Chunk, Decision, Ray, RayKind, Step, Totals};

/// Why a stream is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StreamFault {
    /// Items come in a wrong order.
    #[error("the stream has {found} where {expected} belongs")]
    Order {
        /// The item found.
        found: &'static str,
        /// The item expected.
        expected: &'static str,
    },
    /// A ray does not fit the format.
    #[error("ray {index} of a chunk {fault}")]
    Ray {
        /// The ray's index in its chunk.
        index: usize,
        /// What is wrong with the ray.
        fault: &'static str,
    },
    /// A step names something that does not exist.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A packed word is of no kind of step.
    #[error("{0:#010x} is not a step")]
    NotAStep(u32),
}

/// The counts of a frame that is over, of the tracer and of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameCounts {
    /// The frame's number.
    pub frame: u32,
    /// What the tracer counted.
    pub tracer: Totals,
    /// What the machine replayed.
    pub machine: Totals,
    /// Store steps that the machine performed otherwise than recorded.
    pub stores: StoreWork,
}

counters! {
    /// Store steps that a machine performed otherwise than recorded: they reconcile the counts of both sides. Reads
    /// are performed, merged or raised. Writes (updates included), recorded or added, are performed, merged, gathered,
    /// dropped, deferred or covered.
    pub(crate) struct StoreWork {
        merged_reads: "reads", "reads that a register answered";
        merged_writes: "writes", "writes that a register merged with one that waited";
        raised_reads: "reads", "reads performed as updates: first touches";
        added_writes: "writes", "writes that are not recorded: of a sweep, and of first touches";
        deferred_writes: "writes", "recorded writes of a frame's end that are left to first touches";
        covered_writes: "writes", "recorded writes of a frame's end that a sweep covers";
        dropped_writes: "writes", "updates that change nothing and were dropped at their rays";
        added_reads: "reads", "reads that are not recorded: of learned bits at a frame's end";
        gathered_writes: "writes", "updates that were merged with another of the same hit";
        answered_rays: "rays", "skipped shadow rays that the host answered";
    }
}

/// Whether all steps of a chunk's rays are of known kinds, stand where they may, and name things that exist. Checks
/// the chunk's extent instead of each step.
pub(crate) fn is_sound(chunk: &Chunk, layout: &Layout) -> bool {
    let extent = chunk.extent();
    let exist = extent.outermost().all(|step| layout.check(step).is_ok());
    exist && extent.unknown().is_none() && !extent.strays()
}

/// Checks all rays of a chunk.
pub(crate) fn check_chunk(chunk: &Chunk, layout: &Layout) -> Result<(), StreamFault> {
    parents(chunk)?;
    if is_sound(chunk, layout) {
        return Ok(());
    }
    chunk.rays().zip(0..).try_for_each(|(ray, index)| check_ray(ray, index, layout))
}

/// Checks the steps of ray `index` of a chunk.
pub(crate) fn check_ray(ray: Ray<'_>, index: u32, layout: &Layout) -> Result<(), StreamFault> {
    for &word in ray.packed_path() {
        if !check_step(word, layout)?.is_traversal() {
            return Err(StreamFault::Ray { index: index as usize, fault: "has a policy step in its path" });
        }
    }
    ray.packed_policy().iter().try_for_each(|&word| check_step(word, layout).map(drop))
}

/// The parent of every ray of a chunk, by its index; a primary ray is its own parent.
pub(crate) fn parents(chunk: &Chunk) -> Result<Vec<u32>, StreamFault> {
    let mut group = None;
    let parent = |(index, ray): (usize, Ray<'_>)| {
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

/// Unpacks `word` into a step, and checks that what the step names exists.
#[inline]
pub(crate) fn check_step(word: u32, layout: &Layout) -> Result<Step, StreamFault> {
    let step = Step::unpack(word).ok_or(StreamFault::NotAStep(word))?;
    layout.check(step)?;
    Ok(step)
}
