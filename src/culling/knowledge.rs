//! How recent the memory is that a decision reads.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What of what was learned a decision can read. No choice depends on the number of threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Knowledge {
    /// What was there at the frame's start.
    Latched,
    /// That, and what was learned earlier in the same band of eight rows: several cores, each at a band of its own with
    /// a memory of its own, which are brought together at the frame's end.
    #[default]
    Band,
    /// All that was learned earlier, in raster order: one memory for all.
    Live,
}
