//! The spec of the division units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ranged::Within;

/// Division units, shared by all intersection units of a core. The defaults are those of the T&I engine (Nah et al.
/// 2011, table 4: one unit, a reciprocal of 16 cycles and two more); the queue is assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DivisionSpec {
    /// Units per core.
    pub count: Within<1, 1024>,
    /// Stages of the pipeline.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Cycles from the start of an operation to the start of the next one.
    #[schemars(extend("unit" = "cycles"))]
    pub interval: Within<1, 1000>,
    /// Places of each unit's input queue.
    pub queue: Within<1, 1024>,
}

impl Default for DivisionSpec {
    fn default() -> Self {
        Self {
            count: const { Within::literal(1) },
            latency: const { Within::literal(18) },
            interval: const { Within::literal(1) },
            queue: const { Within::literal(8) },
        }
    }
}
