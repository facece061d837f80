//! How recent the memory is that a decision reads.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which learned data a decision can read. No choice depends on the number of threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Knowledge {
    /// Data learned before the frame started.
    Latched,
    /// As `Latched`, and data learned earlier in the same band of eight rows. This models several cores: each has its
    /// own band and memory, and the memories are merged at the end of the frame.
    #[default]
    Band,
    /// All data learned earlier in raster order: one memory for all cores.
    Live,
}
