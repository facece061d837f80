//! The table of hits whose updates of mode words are gathered: the last shadow ray of a hit takes all of them along.

use rustc_hash::FxHashMap;

use crate::machine::stores::Stores;
use crate::stream::{RayKind, Step};

/// A hit: its chunk by the host's number, and its place in the chunk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct HitId {
    /// The chunk.
    pub chunk: u32,
    /// The place of the ray that has the hit.
    pub place: u32,
}

/// A ray that has done its path.
#[derive(Debug)]
pub struct Retiring<'a> {
    /// What the ray is for.
    pub kind: RayKind,
    /// The hit that it starts on.
    pub hit: HitId,
    /// Traced shadow rays that start there.
    pub siblings: u32,
    /// The packed steps of the path, then those of the policy.
    pub steps: &'a mut Vec<u32>,
    /// Where the policy's steps begin.
    pub path_end: usize,
}

/// A hit with several traced shadow rays, of which some are done with their paths.
#[derive(Clone, Debug, Default)]
struct Hit {
    retired: u32,
    /// The updates gathered, packed, if the hit has an entry of the table.
    updates: Option<Vec<u32>>,
}

/// The table.
#[derive(Clone, Debug)]
pub struct Gathering {
    entries: usize,
    in_use: usize,
    hits: FxHashMap<HitId, Hit>,
}

impl Gathering {
    /// An empty table of so many entries.
    pub fn new(entries: usize) -> Self {
        Self { entries, in_use: 0, hits: FxHashMap::default() }
    }

    /// Whether there is one.
    pub fn is_there(&self) -> bool {
        self.entries > 0
    }

    /// The ray has done its path: leaves its updates in the table, or takes along what is there. Gives how many
    /// updates were merged with others.
    pub fn retire(&mut self, ray: Retiring<'_>, stores: &Stores) -> u64 {
        if ray.kind != RayKind::Shadow || ray.siblings < 2 || !self.is_there() {
            return 0;
        }
        let hit = self.hits.entry(ray.hit).or_default();
        hit.retired += 1;
        let is_last = hit.retired == ray.siblings;
        let is_gathered = |&word: &u32| Step::unpack(word).is_some_and(|step| stores.updates_word(step));
        let has_own = ray.steps[ray.path_end..].iter().any(is_gathered);
        if hit.updates.is_none() && has_own && !is_last && self.in_use < self.entries {
            hit.updates = Some(Vec::new());
            self.in_use += 1;
        }
        let mut merged = 0;
        if let Some(updates) = &mut hit.updates {
            let policy = ray.steps.split_off(ray.path_end);
            let (own, others): (Vec<u32>, Vec<u32>) = policy.into_iter().partition(is_gathered);
            for update in own {
                if updates.iter().any(|&known| Step::unpack(known) == Step::unpack(update)) {
                    merged += 1;
                } else {
                    updates.push(update);
                }
            }
            ray.steps.extend(others);
            if is_last {
                ray.steps.append(updates);
                self.in_use -= 1;
            }
        }
        if is_last {
            self.hits.remove(&ray.hit);
        }
        merged
    }
}
