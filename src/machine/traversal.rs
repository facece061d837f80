//! The spec of the traversal units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::memory::cache::CacheSpec;
use crate::ranged::Within;

/// Traversal units.
///
/// Source: four units of the T&I engine (Nah et al. 2011, table 4: each has 8 stages, one ray per cycle, 20 resident
/// rays and 8 KB of 2 ways).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TraversalSpec {
    /// Units per core.
    pub count: Within<1, 1024>,
    /// Stages of the pipeline.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Cycles from the start of an operation to the start of the next one.
    #[schemars(extend("unit" = "cycles"))]
    pub interval: Within<1, 1000>,
    /// Slots of a unit: the rays it can hold.
    pub rays: Within<1, 4096>,
    /// The L1 of each unit.
    pub cache: CacheSpec,
}

impl Default for TraversalSpec {
    fn default() -> Self {
        Self {
            count: const { Within::literal(4) },
            latency: const { Within::literal(8) },
            interval: const { Within::literal(1) },
            rays: const { Within::literal(20) },
            cache: CacheSpec::DEFAULT,
        }
    }
}
