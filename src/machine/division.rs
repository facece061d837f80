//! The spec of the division units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ranged::Within;

/// Division units, which all intersection units of a core share. The defaults are the T&I engine's (Nah et al. 2011,
/// table 4: one, a reciprocal of 16 cycles and two more); the queue is assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DivisionSpec {
    /// Units a core.
    pub count: Within<1, 1024>,
    /// Stages of the pipeline.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 1000>,
    /// Cycles from an operation to the next.
    #[schemars(extend("unit" = "cycles"))]
    pub interval: Within<1, 1000>,
    /// Places of a unit's input queue.
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
