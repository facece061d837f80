//! Which accesses give a line a place in a cache, by class of traffic.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::stats::TrafficClass;

/// A set of traffic classes, written as a list of names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Vec<TrafficClass>", into = "Vec<TrafficClass>")]
pub struct Classes(u16);

impl Classes {
    /// Whether the set contains `class`.
    pub fn contains(self, class: TrafficClass) -> bool {
        self.0 >> class as usize & 1 == 1
    }
}

impl From<Vec<TrafficClass>> for Classes {
    fn from(classes: Vec<TrafficClass>) -> Self {
        Self(classes.into_iter().fold(0, |set, class| set | 1 << class as usize))
    }
}

impl From<Classes> for Vec<TrafficClass> {
    fn from(classes: Classes) -> Self {
        TrafficClass::ALL.into_iter().filter(|&class| classes.contains(class)).collect()
    }
}

/// Accesses that do not allocate a line: the line is fetched if the access needs its data, but it is not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NoAllocate {
    /// Classes whose reads do not allocate.
    pub reads: Classes,
    /// Classes whose writes do not allocate.
    pub writes: Classes,
}

impl NoAllocate {
    /// All accesses allocate.
    pub const NONE: Self = Self { reads: Classes(0), writes: Classes(0) };

    /// Whether a read, or a write, of `class` allocates.
    pub fn keeps(&self, class: TrafficClass, write: bool) -> bool {
        !(if write { self.writes } else { self.reads }).contains(class)
    }
}
