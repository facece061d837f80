//! The spec of the dispatcher.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ranged::{Size, Within};

/// The dispatcher.
///
/// Source: the T&I engine (Nah et al. 2011, section 4: rays of 128 bytes, one handed over per cycle; its FIFOs have 128
/// places). The latency is the sum of its reciprocal (16 cycles) and its box test (8 cycles). Shading is assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DispatcherSpec {
    /// Pool entries per core, shared by all cores: they limit the rays that are handed over and not done.
    pub rays: Within<1, 65_536>,
    /// Rays handed over per cycle and core.
    pub per_cycle: Within<1, 64>,
    /// Cycles from the hand-over of a ray to its arrival at the traversal unit.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 10_000>,
    /// Places of the in FIFO per core, where rays wait to be handed over.
    pub in_fifo: Within<1, 65_536>,
    /// Places of the out FIFO per core, where finished rays wait for the host.
    pub out_fifo: Within<1, 65_536>,
    /// Bytes of a ray in a FIFO.
    pub ray_bytes: Size<1, 4096>,
    /// Cycles from the host's receipt of a ray's results to the issue of its child rays.
    #[schemars(extend("unit" = "cycles"))]
    pub shading_cycles: Within<1, 1_000_000>,
}

impl Default for DispatcherSpec {
    fn default() -> Self {
        Self {
            rays: const { Within::literal(128) },
            per_cycle: const { Within::literal(1) },
            latency: const { Within::literal(24) },
            in_fifo: const { Within::literal(16) },
            out_fifo: const { Within::literal(16) },
            ray_bytes: const { Size::literal(128) },
            shading_cycles: const { Within::literal(100) },
        }
    }
}
