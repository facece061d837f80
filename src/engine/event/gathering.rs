//! The table of hits whose updates of mode words are gathered: the last shadow ray of a hit takes all of them along.

use rustc_hash::FxHashMap;

use super::ray::Ray;
use crate::machine::stores::Stores;
use crate::stream::{RayKind, Step};

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
    /// By the hit's chunk and place in it.
    hits: FxHashMap<(u32, u32), Hit>,
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
    pub fn retire(&mut self, ray: &mut Ray, stores: &Stores) -> u64 {
        if ray.kind != RayKind::Shadow || ray.siblings < 2 || !self.is_there() {
            return 0;
        }
        let key = (ray.chunk, ray.hit);
        let hit = self.hits.entry(key).or_default();
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
            self.hits.remove(&key);
        }
        merged
    }
}
