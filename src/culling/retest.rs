//! Shared code of the policies that store the last blocker of a shadow ray under a key and test it first. The stored
//! id is only a guess; the test of its triangle on the ray itself proves it. So these policies never decide wrongly.
//!
//! Only static blockers are stored. An entry is kept when its guess fails, and replaced when another blocker is found.

use rustc_hash::FxHashMap;

use super::facts::SceneFacts;
use super::knowledge::Knowledge;
use super::policy::{Change, Evidence, Needs, Policy, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::{Ray, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::stream::{Store, StoreEntries};

/// Maps a shadow ray to its entry of the memory.
pub trait Key: Send + Sync {
    /// Number of entries.
    fn entries(&self) -> u32;
    /// The entry of the shadow ray `ray` from `hit` to `light`.
    fn entry(&self, hit: SurfaceHit, light: LightId, ray: &Ray) -> u32;
}

/// A memory of last blockers.
pub struct Retest<K> {
    key: K,
    knowledge: Knowledge,
    facts: SceneFacts,
    blockers: Vec<Option<PrimitiveId>>,
}

impl<K: Key> Retest<K> {
    /// A memory without any blocker.
    pub fn new(key: K, knowledge: Knowledge, facts: SceneFacts) -> Self {
        let blockers = vec![None; key.entries() as usize];
        Self { key, knowledge, facts, blockers }
    }
}

impl<K: Key> Policy for Retest<K> {
    fn needs(&self) -> Needs {
        Needs { live: self.knowledge == Knowledge::Live, ..Needs::default() }
    }

    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(RetestWorker { policy: self, found: FxHashMap::default() })
    }

    fn end_frame(&mut self, changes: &[Change], _: &mut Trail) {
        // Of several bands' blockers, the last band's is kept. The workers have already recorded the accesses.
        for change in changes {
            self.blockers[change.index as usize] = Some(PrimitiveId(change.value));
        }
    }

    fn stores(&self) -> StoreEntries {
        StoreEntries { occluder_ids: self.blockers.len() as u32, ..StoreEntries::default() }
    }
}

struct RetestWorker<'a, K> {
    policy: &'a Retest<K>,
    /// The last blocker found in this band, by entry.
    found: FxHashMap<u32, PrimitiveId>,
}

impl<K: Key> Worker for RetestWorker<'_, K> {
    fn decide(&mut self, hit: SurfaceHit, light: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict {
        let entry = self.policy.key.entry(hit, light, ray);
        probe.read(Store::OccluderId, entry);
        let kept = self.policy.blockers[entry as usize];
        let fresh = self.found.get(&entry).copied().filter(|_| self.policy.knowledge != Knowledge::Latched);
        match fresh.or(kept) {
            Some(blocker) if probe.blocks(ray, blocker) => Verdict::Dark,
            _ => Verdict::Trace,
        }
    }

    fn learn(&mut self, hit: SurfaceHit, light: LightId, evidence: Evidence, probe: &mut Probe<'_>) {
        if let Some(blocker) = evidence.blocker.filter(|&blocker| !self.policy.facts.is_dynamic(blocker)) {
            let entry = self.policy.key.entry(hit, light, &evidence.ray);
            self.found.insert(entry, blocker);
            probe.write(Store::OccluderId, entry);
        }
    }

    fn finish(self: Box<Self>) -> Vec<Change> {
        // Each entry occurs once, so the order does not matter.
        self.found.into_iter().map(|(index, PrimitiveId(value))| Change { kind: 0, index, value }).collect()
    }
}
