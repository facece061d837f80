//! Classes of memory traffic, and causes of a unit's cycles.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The purpose of memory traffic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrafficClass {
    /// Nodes of the acceleration structure.
    Node,
    /// Primitive lists of the kd-tree.
    List,
    /// Triangle records.
    Triangle,
    /// Mode words.
    ModeWord,
    /// Counters of rendered pixels.
    PixelCounter,
    /// Ids of occluders.
    OccluderId,
    /// Rays and hits.
    Ray,
    /// Pixels of the frame buffer.
    FrameBuffer,
    /// Textures.
    Texture,
    /// Dynamic nodes, lists and triangle records, written by the builder.
    Build,
}

impl TrafficClass {
    /// All classes.
    pub const ALL: [Self; 10] = [
        Self::Node,
        Self::List,
        Self::Triangle,
        Self::ModeWord,
        Self::PixelCounter,
        Self::OccluderId,
        Self::Ray,
        Self::FrameBuffer,
        Self::Texture,
        Self::Build,
    ];

    /// Number of classes that can be cached in an L2: the first ones of [`TrafficClass::ALL`]. Lines of the other
    /// classes bypass all caches and go to the DRAM, as lines of rays do.
    pub const CACHED: usize = 7;

    /// Whether it is the host's own: no cache of the machine keeps its lines.
    pub fn is_of_host(self) -> bool {
        self == Self::Ray || self.goes_past_caches()
    }

    /// Whether its lines bypass all caches: no L2 has a place for them.
    pub fn goes_past_caches(self) -> bool {
        self as usize >= Self::CACHED
    }

    /// The class's name in reports, as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::List => "list",
            Self::Triangle => "triangle",
            Self::ModeWord => "mode_word",
            Self::PixelCounter => "pixel_counter",
            Self::OccluderId => "occluder_id",
            Self::Ray => "ray",
            Self::FrameBuffer => "frame_buffer",
            Self::Texture => "texture",
            Self::Build => "build",
        }
    }
}

/// The cause of a unit's cycle; each cycle has exactly one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The unit began an operation in this cycle.
    Busy,
    /// It had nothing to do: no ray inside, and none in front of it that it could take.
    Starved,
    /// It had rays, all inside its pipeline.
    Pipeline,
    /// It had rays, and the first waiting one waits for data of the cache; of the dispatcher, for the host's port to
    /// the DRAM.
    Memory,
    /// It had a result that its neighbour could not take.
    Blocked,
    /// It took the maximum number of rays in a cycle, began no operation, and others waited in front of it.
    Intake,
}

impl Cause {
    /// All causes, in the order of plots.
    pub const ALL: [Self; 6] = [Self::Busy, Self::Pipeline, Self::Memory, Self::Blocked, Self::Intake, Self::Starved];

    /// The cause's name in reports, as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Busy => "busy",
            Self::Starved => "starved",
            Self::Pipeline => "pipeline",
            Self::Memory => "memory",
            Self::Blocked => "blocked",
            Self::Intake => "intake",
        }
    }
}
