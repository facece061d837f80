//! Updates of mode words of the shadow rays of one hit, gathered until the last of them has done its path.

use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

use super::ray::Ray;
use crate::machine::layout::Layout;
use crate::stream::{Decision, RayKind, Step};

/// The table.
pub struct Gathering {
    places: usize,
    /// Of each hit some of whose shadow rays are done, how many.
    done: BTreeMap<Key, usize>,
    /// The updates of hits that have a place.
    table: BTreeMap<Key, VecDeque<Step>>,
}

/// A hit: its group, which stays where it is while rays of it are under way, and its place there.
type Key = (usize, usize);

impl Gathering {
    pub fn new(places: usize) -> Self {
        Self { places, done: BTreeMap::new(), table: BTreeMap::new() }
    }

    /// A ray has done its path; how many updates are merged thereby.
    pub fn path_done(&mut self, ray: &mut Ray, layout: &Layout) -> u64 {
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
