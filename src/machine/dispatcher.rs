//! The spec of the dispatcher.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ranged::{Size, Within};

/// The dispatcher.
///
/// Source: the T&I engine (Nah et al. 2011, section 4: rays of 128 bytes, one handed over a cycle; its FIFOs have 128
/// places); the latency is its reciprocal of 16 cycles and a box test of 8; shading is assumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DispatcherSpec {
    /// Pool entries a core, shared by all: rays handed over and not done.
    pub rays: Within<1, 65_536>,
    /// Rays handed over a cycle and a core.
    pub per_cycle: Within<1, 64>,
    /// Cycles from the hand-over to the traversal unit.
    #[schemars(extend("unit" = "cycles"))]
    pub latency: Within<1, 10_000>,
    /// Rays a core that can wait to be handed over.
    pub in_fifo: Within<1, 65_536>,
    /// Rays a core that are done and can wait for the host.
    pub out_fifo: Within<1, 65_536>,
    /// Bytes of a ray in a FIFO.
    pub ray_bytes: Size<1, 4096>,
    /// Cycles from the host's taking a ray's results to its children.
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
