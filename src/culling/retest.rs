//! What all policies share that keep the last blocker of a shadow ray under some key and test it first: the id that is
//! read is only a guess, the test of its triangle on the very ray proves it, so they never decide wrongly.
//!
//! Only static blockers are kept. What a key says is not forgotten when the guess fails, only when another blocker is
//! found.

use rustc_hash::FxHashMap;

use super::facts::SceneFacts;
use super::knowledge::Knowledge;
use super::policy::{Change, Evidence, Needs, Policy, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::{Ray, Trail};
use crate::quantity::{LightId, PrimitiveId};
use crate::stream::{Store, StoreEntries};

/// Says which entry of the memory a shadow ray uses.
pub trait Key: Send + Sync {
    /// How many entries there are.
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
    /// Nothing known yet.
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
        // Of several bands that found a blocker the last one's stays. The accesses were recorded as they happened.
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
    /// The last blocker found here, by entry.
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
        // Each entry is there once: their order does not matter.
        self.found.into_iter().map(|(index, PrimitiveId(value))| Change { kind: 0, index, value }).collect()
    }
}
