//! How an L1 handles writes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::memory::allocation::Classes;
use crate::memory::cache::Access;
use crate::stats::TrafficClass;

/// The write policy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum WritePolicy {
    /// Write-back: a write makes its line dirty, and a dirty line is written to the level below when it is evicted.
    #[default]
    Back,
    /// Write-through: a write goes to the level below at once.
    Through,
    /// Write-through for these classes, write-back for all others.
    ThroughFor(Classes),
}

impl WritePolicy {
    /// Whether a write of `class` goes to the L2 at once.
    pub fn go_through(self, class: TrafficClass) -> bool {
        match self {
            Self::Back => false,
            Self::Through => true,
            Self::ThroughFor(classes) => classes.contains(class),
        }
    }

    /// The access of a read, or a write, of `class` to the L1.
    pub fn access(self, class: TrafficClass, write: bool) -> Access {
        match (write, self.go_through(class)) {
            (false, _) => Access::Read,
            (true, false) => Access::Write,
            (true, true) => Access::WriteThrough,
        }
    }
}
