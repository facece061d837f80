//! The ray intersection predictor (Liu et al. 2021, "Intersection Prediction for Accelerated GPU Ray Tracing") for
//! shadow rays. A small table says in which part of the tree a similar ray was blocked. That part is searched first;
//! if nothing blocks there, the ray is traced as usual, so no decision is wrong.
//!
//! The table models an SRAM of 1024 entries, each a tag and a node. It is priced as a store of the same number of
//! occluder ids. One access reads a set.

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::facts::SceneFacts;
use super::knowledge::Knowledge;
use super::policy::{Change, Evidence, Needs, Policy, SurfaceHit, Verdict, Worker};
use super::probe::Probe;
use crate::accel::{Ray, Trail};
use crate::quantity::{LightId, NodeId};
use crate::ranged::{PowerOfTwo, Within};
use crate::stream::{Store, StoreEntries};

/// The predictor's table and hash; the defaults are those of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct HashPredictorSpec {
    /// Sets of the table.
    pub sets: PowerOfTwo<1, 65_536>,
    /// Entries per set.
    pub ways: Within<1, 64>,
    /// Hash bits per coordinate of the ray's origin, relative to the bounding box of the static triangles.
    pub origin_bits: Within<1, 8>,
    /// Hash bits of the polar angle of the ray's direction; the azimuth has one bit more.
    pub sphere_bits: Within<1, 7>,
    /// The table stores the ancestor node this many levels above the blocker's leaf.
    pub levels: Within<1, 64>,
    /// Which learned data a decision can read.
    pub knowledge: Knowledge,
}

impl Default for HashPredictorSpec {
    fn default() -> Self {
        const ALLOWED: &str = "defaults are within their range";
        Self {
            sets: PowerOfTwo::new(256).expect(ALLOWED),
            ways: Within::new(4).expect(ALLOWED),
            origin_bits: Within::new(5).expect(ALLOWED),
            sphere_bits: Within::new(3).expect(ALLOWED),
            levels: Within::new(3).expect(ALLOWED),
            knowledge: Knowledge::default(),
        }
    }
}

impl HashPredictorSpec {
    /// The ray's hash: the cell of its origin in a grid over `bounds`, XOR the leading bits of its direction in
    /// degrees.
    fn hash(&self, ray: &Ray, (low, high): (Vec3, Vec3)) -> u32 {
        let bits = self.origin_bits.get() as u32;
        let cells = (1 << bits) as f32;
        let place = ((ray.origin - low) / (high - low) * cells).to_array();
        // An empty box or a box without width may give a NaN here: the cast makes it cell 0.
        let origin = place.into_iter().fold(0, |hash, at| hash << bits | at.clamp(0.0, cells - 1.0) as u32);
        let direction = ray.direction.normalize_or_zero();
        let theta = direction.z.clamp(-1.0, 1.0).acos().to_degrees() as u32;
        let phi = (direction.y.atan2(direction.x).to_degrees() + 180.0) as u32;
        let bits = self.sphere_bits.get() as u32;
        origin ^ (phi >> (8 - bits) << bits | theta >> (8 - bits))
    }
}

/// An entry of the table.
#[derive(Clone, Copy, Default)]
struct Entry {
    tag: u32,
    node: NodeId,
    /// Clock value of the last use; 0 for an empty entry.
    used: u64,
}

/// The table: sets of entries with LRU replacement.
#[derive(Clone)]
struct Table {
    sets: u32,
    ways: usize,
    entries: Vec<Entry>,
    clock: u64,
}

impl Table {
    fn new(spec: &HashPredictorSpec) -> Self {
        let (sets, ways) = (spec.sets.get() as u32, spec.ways.size());
        Self { sets, ways, entries: vec![Entry::default(); spec.sets.size() * ways], clock: 0 }
    }

    fn first(&self, hash: u32) -> usize {
        (hash % self.sets) as usize * self.ways
    }

    fn set(&mut self, hash: u32) -> &mut [Entry] {
        let first = self.first(hash);
        self.clock += 1;
        &mut self.entries[first..first + self.ways]
    }

    /// The node stored for `hash`.
    fn peek(&self, hash: u32) -> Option<NodeId> {
        let first = self.first(hash);
        let set = &self.entries[first..first + self.ways];
        set.iter().find(|entry| entry.used > 0 && entry.tag == hash / self.sets).map(|entry| entry.node)
    }

    /// Marks the entry of `hash` as the most recently used, if there is one.
    fn touch(&mut self, hash: u32) {
        let tag = hash / self.sets;
        let now = self.clock + 1;
        if let Some(entry) = self.set(hash).iter_mut().find(|entry| entry.used > 0 && entry.tag == tag) {
            entry.used = now;
        }
    }

    /// Stores `node` for `hash`.
    fn keep(&mut self, hash: u32, node: NodeId) {
        let tag = hash / self.sets;
        let now = self.clock + 1;
        let set = self.set(hash);
        let at = set.iter().position(|entry| entry.used > 0 && entry.tag == tag);
        let oldest = || set.iter().enumerate().min_by_key(|(_, entry)| entry.used).map_or(0, |(at, _)| at);
        let at = at.unwrap_or_else(oldest);
        set[at] = Entry { tag, node, used: now };
    }
}

/// The predictor, as of the frame's start.
pub struct HashPredictor {
    spec: HashPredictorSpec,
    facts: SceneFacts,
    table: Table,
}

/// Kinds of [`Change`]: the entry of a hash was used; a node is stored for a hash.
const TOUCH: u32 = 0;
const KEEP: u32 = 1;

impl HashPredictor {
    /// A predictor with an empty table.
    pub fn new(spec: HashPredictorSpec, facts: SceneFacts) -> Self {
        Self { spec, facts, table: Table::new(&spec) }
    }
}

impl Policy for HashPredictor {
    fn needs(&self) -> Needs {
        Needs { live: self.spec.knowledge == Knowledge::Live, ..Needs::default() }
    }

    fn worker(&self) -> Box<dyn Worker + '_> {
        Box::new(PredictorWorker { policy: self, table: self.table.clone(), changes: Vec::new() })
    }

    fn end_frame(&mut self, changes: &[Change], _: &mut Trail) {
        // Repeats the accesses in the order of the stream. They are not recorded again: the workers have recorded
        // them.
        for change in changes {
            match change.kind {
                TOUCH => self.table.touch(change.index),
                _ => self.table.keep(change.index, NodeId(change.value)),
            }
        }
    }

    fn stores(&self) -> StoreEntries {
        StoreEntries { occluder_ids: self.table.entries.len() as u32, ..StoreEntries::default() }
    }
}

struct PredictorWorker<'a> {
    policy: &'a HashPredictor,
    table: Table,
    changes: Vec<Change>,
}

impl PredictorWorker<'_> {
    fn change(&mut self, change: Change) {
        if self.policy.spec.knowledge != Knowledge::Latched {
            match change.kind {
                TOUCH => self.table.touch(change.index),
                _ => self.table.keep(change.index, NodeId(change.value)),
            }
        }
        self.changes.push(change);
    }
}

impl Worker for PredictorWorker<'_> {
    fn decide(&mut self, _: SurfaceHit, _: LightId, ray: &Ray, probe: &mut Probe<'_>) -> Verdict {
        let hash = self.policy.spec.hash(ray, probe.static_bounds());
        probe.read(Store::OccluderId, self.table.first(hash) as u32);
        let Some(node) = self.table.peek(hash) else { return Verdict::Trace };
        self.change(Change { kind: TOUCH, index: hash, value: 0 });
        if probe.blocked_below(ray, node) { Verdict::Dark } else { Verdict::Trace }
    }

    fn learn(&mut self, _: SurfaceHit, _: LightId, evidence: Evidence, probe: &mut Probe<'_>) {
        let facts = self.policy.facts;
        if let Some(blocker) = evidence.blocker.filter(|&blocker| !facts.is_dynamic(blocker)) {
            let hash = self.policy.spec.hash(&evidence.ray, probe.static_bounds());
            let node = probe.ancestor(blocker, self.policy.spec.levels.get() as u32);
            self.change(Change { kind: KEEP, index: hash, value: node.0 });
            probe.update(Store::OccluderId, self.table.first(hash) as u32);
        }
    }

    fn finish(self: Box<Self>) -> Vec<Change> {
        self.changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_recently_used_entry_goes() {
        let spec = HashPredictorSpec { ways: Within::new(2).unwrap(), ..HashPredictorSpec::default() };
        let mut table = Table::new(&spec);
        let hash = |tag: u32| tag * 256 + 7;
        table.keep(hash(1), NodeId(10));
        table.keep(hash(2), NodeId(20));
        table.touch(hash(1));
        table.keep(hash(3), NodeId(30));
        assert_eq!([1, 2, 3].map(|tag| table.peek(hash(tag))), [Some(NodeId(10)), None, Some(NodeId(30))]);
        table.keep(hash(3), NodeId(31));
        assert_eq!([1, 3].map(|tag| table.peek(hash(tag))), [Some(NodeId(10)), Some(NodeId(31))]);
        assert_eq!(table.peek(hash(1) + 1), None);
    }

    #[test]
    fn hashes_by_hand() {
        let spec = HashPredictorSpec::default();
        let bounds = (Vec3::ZERO, Vec3::splat(32.0));
        let hash =
            |origin: [f32; 3], direction: Vec3| spec.hash(&Ray::new(Vec3::from_array(origin), direction, 1.0), bounds);
        // Straight up: polar angle 0, azimuth 180 degrees, whose leading bits are 5.
        assert_eq!(hash([0.0; 3], Vec3::Z), 5 << 3);
        assert_eq!(hash([1.5, 2.5, 3.5], Vec3::Z), (1 << 10 | 2 << 5 | 3) ^ (5 << 3));
        // Points outside belong to the outermost cells.
        assert_eq!(hash([-9.0, 99.0, 31.9], Vec3::Z), (31 << 5 | 31) ^ (5 << 3));
        // Straight down: 180 degrees.
        assert_eq!(hash([0.0; 3], Vec3::new(0.0, 0.0, -1.0)), 5 << 3 | 5);
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        assert_eq!(spec.hash(&Ray::new(Vec3::ONE, Vec3::Z, 1.0), none), 5 << 3);
    }
}
