//! The gather table: collects the mode-word updates of a hit, which the hit's last shadow ray performs.

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::machine::stores::Stores;
use crate::stream::{RayKind, Step};

/// A hit: the host's number of its chunk, and the index in that chunk of the ray that has the hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct HitId {
    /// The chunk.
    pub chunk: u32,
    /// The index of the ray that has the hit.
    pub place: u32,
}

/// A ray whose path is done.
#[derive(Debug)]
pub(super) struct Retiring<'a> {
    /// The ray's kind.
    pub kind: RayKind,
    /// The hit that the ray starts on.
    pub hit: HitId,
    /// Number of traced shadow rays that start on this hit.
    pub siblings: u32,
    /// The packed steps of the path, then those of the policy.
    pub steps: &'a mut Vec<u32>,
    /// Index of the first step of the policy.
    pub path_end: usize,
}

/// Updates of a hit that need no allocation of their own: most hits have one or two words.
const MOST_AT_HAND: usize = 4;

/// A hit with several traced shadow rays, some of which are done with their paths.
#[derive(Clone, Debug, Default)]
struct Hit {
    retired: u32,
    /// The gathered updates, packed; `None` if the hit has no entry in the table.
    updates: Option<SmallVec<[u32; MOST_AT_HAND]>>,
}

/// The table.
#[derive(Clone, Debug)]
pub(super) struct Gathering {
    entries: usize,
    in_use: usize,
    hits: FxHashMap<HitId, Hit>,
}

impl Gathering {
    /// An empty table of `entries` entries.
    pub(super) fn new(entries: usize) -> Self {
        Self { entries, in_use: 0, hits: FxHashMap::default() }
    }

    /// Whether the machine has a gather table.
    pub(super) fn is_there(&self) -> bool {
        self.entries > 0
    }

    /// Retires a ray: moves its updates to the hit's table entry, if the hit has one. The hit's last ray takes all
    /// gathered updates along. Returns the number of updates merged with others.
    pub(super) fn retire(&mut self, ray: Retiring<'_>, stores: &Stores) -> u64 {
        if ray.kind != RayKind::Shadow || ray.siblings < 2 || !self.is_there() {
            return 0;
        }
        let hit = self.hits.entry(ray.hit).or_default();
        hit.retired += 1;
        let is_last = hit.retired == ray.siblings;
        let is_gathered = |&word: &u32| Step::unpack(word).is_some_and(|step| stores.updates_word(step));
        let has_own = ray.steps[ray.path_end..].iter().any(is_gathered);
        if hit.updates.is_none() && has_own && !is_last && self.in_use < self.entries {
            hit.updates = Some(SmallVec::new());
            self.in_use += 1;
        }
        let mut merged = 0;
        if let Some(updates) = &mut hit.updates {
            let mut kept = ray.path_end;
            for at in ray.path_end..ray.steps.len() {
                let step = ray.steps[at];
                if !is_gathered(&step) {
                    ray.steps[kept] = step;
                    kept += 1;
                } else if updates.iter().any(|&known| Step::unpack(known) == Step::unpack(step)) {
                    merged += 1;
                } else {
                    updates.push(step);
                }
            }
            ray.steps.truncate(kept);
            if is_last {
                ray.steps.extend_from_slice(updates);
                self.in_use -= 1;
            }
        }
        if is_last {
            self.hits.remove(&ray.hit);
        }
        merged
    }
}
