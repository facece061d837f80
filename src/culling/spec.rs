//! The table of policies: what a config can name.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::facts::SceneFacts;
use super::policy::{Needs, Policy};
use super::{
    certificates, certified, hash_predictor, hybrid, last_occluder, occluder_grid, off, oracle, published, sato,
    symmetric,
};
use crate::scene::Lamps;

/// A culling policy as a config names it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum PolicySpec {
    /// No culling: the baseline of all savings.
    Off,
    /// The published algorithm (GI09).
    Published(#[serde(default)] published::rules::PublishedSpec),
    /// The published algorithm (GI09) with occlusion tests in both directions.
    Symmetric(#[serde(default)] symmetric::SymmetricSpec),
    /// Stores the last blocker of each primitive and light, and tests it first.
    LastOccluder(#[serde(default)] last_occluder::LastOccluderSpec),
    /// Stores the last blocker of each light and direction, and tests it first.
    OccluderGrid(#[serde(default)] occluder_grid::OccluderGridSpec),
    /// Predicts by a hash of the ray which part of the tree blocks it, and searches that part first.
    HashPredictor(#[serde(default)] hash_predictor::HashPredictorSpec),
    /// No culling: shadow rays visit larger boxes first.
    Sato,
    /// Proves for cells of receivers that a light is blocked or visible; exact.
    Certified(#[serde(default)] certificates::CertificateSpec),
    /// `Certified`, and a test of the last blocker where a cell has no proof; exact.
    Hybrid(#[serde(default)] hybrid::HybridSpec),
    /// The limit of culling: the answers for static triangles are known at no cost.
    Oracle,
}

impl PolicySpec {
    /// Whether the policy needs a tree of boxes (a BVH).
    pub fn needs_boxes(&self) -> bool {
        matches!(self, Self::HashPredictor(_) | Self::Sato)
    }

    /// The policy at the start of an animation.
    pub fn build(&self, facts: SceneFacts) -> Box<dyn Policy> {
        match self {
            Self::Off => Box::new(off::Off),
            Self::Published(spec) => Box::new(published::Published::new(spec.rules(), facts)),
            Self::Symmetric(spec) => Box::new(published::Published::new(spec.rules(), facts)),
            Self::LastOccluder(spec) => Box::new(spec.build(facts)),
            Self::OccluderGrid(spec) => Box::new(spec.build(facts)),
            Self::HashPredictor(spec) => Box::new(hash_predictor::HashPredictor::new(*spec, facts)),
            Self::Sato => Box::new(sato::Sato),
            Self::Certified(spec) => Box::new(certified::Certified::new(*spec, facts)),
            Self::Hybrid(spec) => Box::new(hybrid::Hybrid::new(*spec, facts)),
            Self::Oracle => Box::new(oracle::Oracle),
        }
    }

    /// What it needs of the tracer, whatever the scene.
    pub fn needs(&self) -> Needs {
        self.build(SceneFacts { statics: 0, primitives: 0, lights: 0, lamps: Lamps::points() }).needs()
    }

    /// Entries of its largest store. It is known before the policy is built, which takes memory for all entries.
    pub fn largest_store(&self, facts: SceneFacts) -> u64 {
        let SceneFacts { primitives, lights, .. } = facts;
        match self {
            Self::LastOccluder(_) => u64::from(primitives) * u64::from(lights),
            Self::OccluderGrid(spec) => 6 * spec.cells.get().pow(2) * u64::from(lights),
            _ => {
                let stores = self.build(facts).stores();
                u64::from(stores.mode_words.max(stores.pixel_counters).max(stores.occluder_ids))
            }
        }
    }

    /// Whether it keeps what it learns for later frames.
    pub fn learns(&self, facts: SceneFacts) -> bool {
        self.largest_store(facts) > 0
    }

    /// Every policy with its defaults.
    pub fn all() -> Vec<(&'static str, Self)> {
        vec![
            ("Off", Self::Off),
            ("Published", Self::Published(Default::default())),
            ("Symmetric", Self::Symmetric(Default::default())),
            ("LastOccluder", Self::LastOccluder(Default::default())),
            ("OccluderGrid", Self::OccluderGrid(Default::default())),
            ("HashPredictor", Self::HashPredictor(Default::default())),
            ("Sato", Self::Sato),
            ("Certified", Self::Certified(Default::default())),
            ("Hybrid", Self::Hybrid(Default::default())),
            ("Oracle", Self::Oracle),
        ]
    }

    /// Whether no decision can be wrong. Tests fail if such a policy decides wrongly.
    pub fn is_exact(&self) -> bool {
        match self {
            Self::Published(_) | Self::Symmetric(_) => false,
            Self::Off | Self::LastOccluder(_) | Self::OccluderGrid(_) | Self::HashPredictor(_) | Self::Sato => true,
            Self::Certified(_) | Self::Hybrid(_) | Self::Oracle => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts(primitives: u32, lights: u32) -> SceneFacts {
        SceneFacts { statics: primitives, primitives, lights, lamps: Lamps::points() }
    }

    #[test]
    fn the_largest_store_is_known_before_a_policy_is_built() {
        for (name, policy) in PolicySpec::all() {
            let stores = policy.build(facts(100, 3)).stores();
            let largest = stores.mode_words.max(stores.pixel_counters).max(stores.occluder_ids);
            assert_eq!(policy.largest_store(facts(100, 3)), u64::from(largest), "{name}");
            assert_eq!(policy.needs(), policy.build(facts(100, 3)).needs(), "{name}");
        }
    }

    /// More than a step can number, and more than 32 bits hold.
    #[test]
    fn large_stores_are_counted_in_full() {
        let last = PolicySpec::LastOccluder(last_occluder::LastOccluderSpec::default());
        assert_eq!(last.largest_store(facts(100_000_000, 64)), 6_400_000_000);
        let grid =
            occluder_grid::OccluderGridSpec { cells: crate::ranged::Within::literal(1024), ..Default::default() };
        assert_eq!(PolicySpec::OccluderGrid(grid).largest_store(facts(1, 22)), 138_412_032);
    }
}
