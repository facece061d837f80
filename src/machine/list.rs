//! The spec of the list units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::memory::cache::CacheSpec;
use crate::ranged::{Size, Within};

/// List units.
///
/// Source: one of the six units of the T&I engine (Nah et al. 2011, table 4 and section 5: 4 KB of 2 ways each).
/// Latency, contexts and queue are assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ListSpec {
    /// Units per core.
    pub count: Within<1, 1024>,
    /// Stages of the pipeline.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Cycles from the start of an operation to the start of the next one.
    #[schemars(extend("unit" = "cycles"))]
    pub interval: Within<1, 1000>,
    /// Rays in a unit at once, including rays that are at an intersection unit.
    pub lists: Within<1, 4096>,
    /// Places of each unit's input queue.
    pub queue: Within<1, 1024>,
    /// The L1 of each unit.
    pub cache: CacheSpec,
}

impl Default for ListSpec {
    fn default() -> Self {
        Self {
            count: const { Within::literal(1) },
            latency: const { Within::literal(2) },
            interval: const { Within::literal(1) },
            lists: const { Within::literal(32) },
            queue: const { Within::literal(8) },
            cache: const { CacheSpec { bytes: Size::literal(4 << 10), ..CacheSpec::DEFAULT } },
        }
    }
}
