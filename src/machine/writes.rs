//! How an L1 handles writes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::memory::allocation::Classes;
use crate::memory::cache::Access;
use crate::stats::TrafficClass;

/// What becomes of writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum WritePolicy {
    /// A write makes its line dirty; dirty lines go down when they are displaced.
    #[default]
    Back,
    /// A write goes down at once.
    Through,
    /// Writes of these classes go down at once, others do not.
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
