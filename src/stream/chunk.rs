//! A chunk of rays in memory: heads in one column, all steps in another.

use std::ops::Range;

use super::extent::Extent;
use super::step::{Effect, Step, Store};
use crate::quantity::{LightId, PixelId, PrimitiveId};

/// The purpose of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RayKind {
    /// From the camera; its pixel group begins here.
    Primary,
    /// Towards a light.
    Shadow,
    /// Reflected.
    Reflection,
    /// Refracted.
    Refraction,
}

impl RayKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Primary, Self::Shadow, Self::Reflection, Self::Refraction];

    /// The kind's name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
        }
    }
}

/// The culling policy's decision for a shadow ray; other rays are always traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Decision {
    /// Trace it among everything.
    Trace,
    /// Known to be lit past all static objects: trace it among dynamic objects only.
    DynamicOnly,
    /// The answer is known: trace nothing.
    Skip,
}

impl Decision {
    /// All decisions.
    pub const ALL: [Self; 3] = [Self::Trace, Self::DynamicOnly, Self::Skip];
}

/// A ray's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// A primary or secondary ray hits nothing.
    Miss,
    /// A primary or secondary ray's nearest hit.
    Hit(PrimitiveId),
    /// The light is seen.
    Lit,
    /// The light is not seen.
    Dark,
}

/// A ray without its steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayHead {
    /// The ray's purpose.
    pub kind: RayKind,
    /// The light that a shadow ray goes to; 0 for others.
    pub light: LightId,
    /// The policy's decision.
    pub decision: Decision,
    /// The result.
    pub outcome: Outcome,
    /// The pixel.
    pub pixel: PixelId,
    /// Distance back in the chunk, in rays, to the parent, on whose hit the ray starts; 0 for a primary ray.
    pub parent: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    head: RayHead,
    /// Index in `steps` at which the path's steps end and the policy's begin.
    path_end: u32,
    /// Index in `steps` at which the policy's steps end.
    end: u32,
}

/// Rays in order. Whole pixel groups only: a chunk begins with a primary ray.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chunk {
    entries: Vec<Entry>,
    steps: Vec<u32>,
    attributed: bool,
}

/// A ray of a chunk.
#[derive(Clone, Copy, Debug)]
pub struct Ray<'a> {
    /// The ray without its steps.
    pub head: RayHead,
    /// Whether the ray's accesses are attributed: counted separately.
    pub attributed: bool,
    path: &'a [u32],
    policy: &'a [u32],
}

impl<'a> Ray<'a> {
    /// The traversal's steps, in order.
    pub fn path(&self) -> impl ExactSizeIterator<Item = Step> + use<'a> {
        Step::unpack_all(self.path)
    }

    /// The policy's steps for this ray. For a hit: before the hit's shadow rays are decided. For a shadow ray: after
    /// its answer is known.
    pub fn policy(&self) -> impl ExactSizeIterator<Item = Step> + use<'a> {
        Step::unpack_all(self.policy)
    }

    /// The packed steps of the path.
    pub fn packed_path(&self) -> &'a [u32] {
        self.path
    }

    /// The packed steps of the policy.
    pub fn packed_policy(&self) -> &'a [u32] {
        self.policy
    }
}

impl Chunk {
    /// Adds a ray. `path` and `policy` are packed steps, every one valid.
    pub fn push(&mut self, head: RayHead, path: &[u32], policy: &[u32]) {
        debug_assert!(path.iter().all(|&word| Step::unpack(word).is_some_and(Step::is_traversal)));
        debug_assert!(policy.iter().all(|&word| Step::unpack(word).is_some()));
        self.steps.extend_from_slice(path);
        let path_end = self.steps.len() as u32;
        self.steps.extend_from_slice(policy);
        self.entries.push(Entry { head, path_end, end: self.steps.len() as u32 });
    }

    /// Sets the effect of an update of a mode word: step `at` of all rays' steps. The id does not change, so the extent
    /// does not.
    pub fn set_effect(&mut self, at: usize, effect: Effect) {
        let step = Step::unpack(self.steps[at]).and_then(Step::entry);
        debug_assert!(step.is_some_and(|(store, _)| store == Store::ModeWord));
        if let Some((_, index)) = step {
            self.steps[at] = Step::pack_word_update(index, effect);
        }
    }

    /// Adds rays of another chunk.
    pub fn extend(&mut self, other: &Self, rays: Range<usize>) {
        let (first, begin) = (other.begin(rays.start) as u32, self.steps.len() as u32);
        self.steps.extend_from_slice(other.packed_steps_of(rays.clone()));
        let moved = |at: u32| at - first + begin;
        let entries = other.entries[rays].iter();
        self.entries.extend(entries.map(|entry| Entry {
            head: entry.head,
            path_end: moved(entry.path_end),
            end: moved(entry.end),
        }));
    }

    /// A chunk of `rays`, each with the lengths of its path's and its policy's steps; `steps` holds these steps ray
    /// after ray. `None` if the lengths do not add up to `steps`. No step may be unpacked before a `Checker` has seen
    /// the chunk.
    pub(super) fn from_columns<E>(
        rays: impl ExactSizeIterator<Item = Result<(RayHead, [u32; 2]), E>>,
        steps: Vec<u32>,
    ) -> Result<Option<Self>, E> {
        let mut end = 0u32;
        let mut entries = Vec::with_capacity(rays.len());
        for ray in rays {
            let (head, [path, policy]) = ray?;
            let Some(path_end) = end.checked_add(path) else { return Ok(None) };
            let Some(policy_end) = path_end.checked_add(policy) else { return Ok(None) };
            end = policy_end;
            entries.push(Entry { head, path_end, end });
        }
        if end as usize != steps.len() {
            return Ok(None);
        }
        Ok(Some(Self { entries, steps, attributed: false }))
    }

    /// The largest ids of all steps, found by a pass over them. A chunk whose extent fits a machine needs no check of
    /// single steps.
    pub fn extent(&self) -> Extent {
        let policies = self.entries.iter().map(|entry| &self.steps[entry.path_end as usize..entry.end as usize]);
        Extent::of(&self.steps, policies.filter(|words| !words.is_empty()))
    }

    /// Attributes the accesses of the chunk's rays: they are counted separately. Files do not store this.
    pub fn attribute(&mut self) {
        self.attributed = true;
    }

    /// Whether the accesses of the chunk's rays are counted separately.
    pub fn is_attributed(&self) -> bool {
        self.attributed
    }

    /// The number of rays.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Bytes of memory that the rays take.
    pub fn bytes(&self) -> usize {
        size_of_val(self.entries.as_slice()) + size_of_val(self.steps.as_slice())
    }

    /// Whether there is no ray.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The number of steps of all rays.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// The packed steps of all rays: for each ray the path's, then the policy's.
    pub(super) fn packed_steps(&self) -> &[u32] {
        &self.steps
    }

    /// The packed steps of some rays, in order.
    pub fn packed_steps_of(&self, rays: Range<usize>) -> &[u32] {
        &self.steps[self.begin(rays.start)..self.begin(rays.end)]
    }

    /// Index of the first step of ray `index`; with the number of rays as `index`, the number of steps.
    fn begin(&self, index: usize) -> usize {
        if index == 0 { 0 } else { self.entries[index - 1].end as usize }
    }

    /// All rays without their steps, in order.
    pub(crate) fn heads(&self) -> impl ExactSizeIterator<Item = RayHead> {
        self.entries.iter().map(|entry| entry.head)
    }

    /// Ray `index` without its steps.
    #[inline]
    pub fn head(&self, index: usize) -> RayHead {
        self.entries[index].head
    }

    /// Ray `index`.
    #[inline]
    pub fn ray(&self, index: usize) -> Ray<'_> {
        let start = self.begin(index);
        let Entry { head, path_end, end } = self.entries[index];
        let (path_end, end) = (path_end as usize, end as usize);
        Ray {
            head,
            attributed: self.attributed,
            path: &self.steps[start..path_end],
            policy: &self.steps[path_end..end],
        }
    }

    /// All rays in order.
    pub fn rays(&self) -> impl ExactSizeIterator<Item = Ray<'_>> + Clone {
        (0..self.len()).map(|index| self.ray(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{ListId, NodeId, TriangleSlot};
    use crate::stream::Stop;

    fn head(pixel: u32) -> RayHead {
        let (kind, light) = (RayKind::Primary, LightId(0));
        let (decision, outcome) = (Decision::Trace, Outcome::Hit(PrimitiveId(pixel)));
        RayHead { kind, light, decision, outcome, pixel: PixelId(pixel), parent: 0 }
    }

    /// Ray `n` has `n` steps of the path and `n / 2` of the policy.
    fn chunk(rays: Range<u32>) -> Chunk {
        let mut chunk = Chunk::default();
        for ray in rays {
            let node = |index| Step::Node(NodeId(index)).pack();
            let path: Vec<u32> = (0..ray).map(|index| node(100 * ray + index)).collect();
            chunk.push(head(ray), &path, &path[..ray as usize / 2]);
        }
        chunk
    }

    #[test]
    fn rays_of_several_chunks_are_as_if_pushed_one_by_one() {
        let mut joined = Chunk::default();
        joined.extend(&chunk(0..6), 0..6);
        joined.extend(&chunk(3..10), 3..3);
        joined.extend(&chunk(3..10), 3..7);
        assert_eq!(joined, chunk(0..10));
        assert_eq!(joined.packed_steps_of(0..10), joined.packed_steps());
        let ray = joined.ray(7);
        assert_eq!(joined.packed_steps_of(7..8), [ray.packed_path(), ray.packed_policy()].concat());
    }

    #[test]
    fn steps_of_a_path_are_counted_by_tag() {
        let triangle = |stop| Step::Triangle { slot: TriangleSlot(7), stop };
        let (node, list) = (Step::Node(NodeId(Step::MAX_INDEX)), Step::List(ListId(Step::MAX_INDEX)));
        let steps = [node, node, list, triangle(Stop::Plane), triangle(Stop::Edges), triangle(Stop::Hit)];
        assert_eq!(Step::count(&steps.map(Step::pack)), [2, 1, 3]);
        assert_eq!(Step::count(&[]), [0; 3]);
    }
}
