//! The spec of the intersection units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::memory::cache::CacheSpec;
use crate::ranged::{Size, Within};

/// Intersection units.
///
/// Source: two units of the T&I engine (Nah et al. 2011, table 4: each has 18 stages and 16 KB of 4 ways). The queue
/// and the number of tests are assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct IntersectionSpec {
    /// Units per core.
    pub count: Within<1, 1024>,
    /// Stages of the pipeline.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Cycles from the start of an operation to the start of the next one.
    #[schemars(extend("unit" = "cycles"))]
    pub interval: Within<1, 1000>,
    /// Tests in a unit at once, including tests that are at a division unit.
    pub tests: Within<1, 4096>,
    /// Places of each unit's input queue.
    pub queue: Within<1, 1024>,
    /// The L1 of each unit.
    pub cache: CacheSpec,
}

impl Default for IntersectionSpec {
    fn default() -> Self {
        Self {
            count: const { Within::literal(2) },
            latency: const { Within::literal(18) },
            interval: const { Within::literal(1) },
            tests: const { Within::literal(32) },
            queue: const { Within::literal(8) },
            cache: const { CacheSpec { bytes: Size::literal(16 << 10), ways: Within::literal(4), ..CacheSpec::DEFAULT } },
        }
    }
}
