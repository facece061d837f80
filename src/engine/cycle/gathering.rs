//! Gathers updates of mode words from the shadow rays of a hit, until the last of these rays has ended its path.

use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

use super::ray::Ray;
use crate::machine::layout::Layout;
use crate::stream::{Decision, RayKind, Step};

/// The table of gathered updates.
pub(super) struct Gathering {
    places: usize,
    /// Shadow rays of each hit that have ended their path; absent for none.
    done: BTreeMap<Key, usize>,
    /// Gathered updates of hits that have a place in the table.
    table: BTreeMap<Key, VecDeque<Step>>,
}

/// A hit: the address of its group, which does not move while its rays are in flight, and its index there.
type Key = (usize, usize);

impl Gathering {
    pub(super) fn new(places: usize) -> Self {
        Self { places, done: BTreeMap::new(), table: BTreeMap::new() }
    }

    /// A ray has ended its path; returns the number of updates merged.
    pub(super) fn path_done(&mut self, ray: &mut Ray, layout: &Layout) -> u64 {
        let Some(origin) = ray.origin.as_ref().filter(|_| self.places > 0 && ray.kind == RayKind::Shadow) else {
            return 0;
        };
        let back = origin.group.chunk.head(origin.index).parent as usize;
        let hit = origin.index - back;
        let heads = origin.group.children[hit].iter().map(|&child| origin.group.chunk.head(child));
        let sent = heads.filter(|head| head.kind == RayKind::Shadow && head.decision != Decision::Skip).count();
        let key = (Rc::as_ptr(&origin.group) as usize, hit);
        let done = self.done.entry(key).or_default();
        *done += 1;
        let last = *done == sent;
        if last {
            self.done.remove(&key);
        }
        let is_gathered = |step: &Step| layout.stores().updates_word(*step);
        let has_own = ray.policy.iter().any(is_gathered);
        if !self.table.contains_key(&key) && (last || !has_own || self.table.len() == self.places) {
            return 0;
        }
        let (own, mut rest): (VecDeque<Step>, VecDeque<Step>) = ray.policy.drain(..).partition(is_gathered);
        let gathered = self.table.entry(key).or_default();
        let mut merged = 0;
        for step in own {
            if gathered.contains(&step) {
                merged += 1;
            } else {
                gathered.push_back(step);
            }
        }
        if last {
            rest.extend(self.table.remove(&key).unwrap_or_default());
        }
        ray.policy = rest;
        merged
    }
}
