//! The config of the table, and its rows.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::accel::AccelSpec;
use crate::quantity::Resolution;
use crate::ranged::Within;
use crate::tracer::Directions;

/// Replays rays of one kind at a time on a machine, and compares the figures with published rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentitiesSpec {
    /// The machine's file.
    pub machine: PathBuf,
    /// The scenes, each with one frame.
    pub scenes: Vec<SceneFrame>,
    /// Size of the pictures.
    pub resolution: Resolution,
    /// Camera rays per pixel.
    #[serde(default = "one")]
    pub samples: Within<1, 1024>,
    /// Directions of ambient-occlusion rays and diffuse rays.
    #[serde(default)]
    pub directions: Directions,
    /// The acceleration structure.
    pub accel: AccelSpec,
    /// Published rows, shown beside the simulated ones.
    pub published: Vec<Row>,
}

/// A frame of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFrame {
    /// The scene's file.
    pub scene: PathBuf,
    /// The frame's number.
    pub frame: u32,
    /// Length of ambient-occlusion rays, in units of the scene. Without it there are no such rays.
    #[serde(default)]
    pub reach: Option<f32>,
}

fn one() -> Within<1, 1024> {
    const { Within::literal(1) }
}

/// One figure per kind of unit. The figure of division units may be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PerUnit {
    /// Traversal units.
    pub traversal: f64,
    /// List units.
    pub list: f64,
    /// Intersection units.
    pub intersection: f64,
    /// Division units.
    #[serde(default)]
    pub division: f64,
}

/// A published row of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Scene and kind of rays.
    pub name: String,
    /// Utilization: share of cycles in which an operation occupies the unit.
    pub utilization: PerUnit,
    /// Hit rates of the L1s.
    pub l1: PerUnit,
    /// Hit rates of the L2, for the traffic class of each kind of unit.
    pub l2: PerUnit,
    /// Operations per ray.
    pub operations: PerUnit,
    /// DRAM traffic in GB/s.
    pub dram_gb_per_s: f64,
    /// Millions of rays per second.
    pub mrays_per_s: f64,
    /// DRAM traffic in bytes per ray.
    pub dram_bytes_per_ray: f64,
}
