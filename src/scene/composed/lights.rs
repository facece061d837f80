//! Lights as a config gives them.

use glam::{DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use crate::ranged::Within;
use crate::scene::fields;
use crate::scene::lamps::rectangle;
use crate::scene::light::{Light, MAX_LIGHTS};
use crate::scene::limits::LENGTH;

/// A light: a point, or a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LightSpec {
    /// Position of a point light, or centre of a rectangle.
    #[serde(deserialize_with = "fields::point")]
    #[schemars(with = "[f64; 3]")]
    pub position: DVec3,
    /// Colour and intensity; white if left out.
    #[serde(default = "white", deserialize_with = "fields::color")]
    #[schemars(with = "[f32; 3]")]
    pub color: Vec3,
    /// Edges and points of a rectangular light; a point light if left out.
    #[serde(default)]
    pub area: Option<AreaSpec>,
}

/// A rectangular light (or any parallelogram), which casts soft shadows. Every hit sends a shadow ray to each of its
/// points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaSpec {
    /// Vector of half of one edge.
    #[serde(deserialize_with = "fields::nonzero")]
    #[schemars(with = "[f64; 3]")]
    pub u: DVec3,
    /// Vector of half of the other edge.
    #[serde(deserialize_with = "fields::nonzero")]
    #[schemars(with = "[f64; 3]")]
    pub v: DVec3,
    /// Number of points along each edge.
    pub points: Within<1, 8>,
}

fn white() -> Vec3 {
    Vec3::ONE
}

impl LightSpec {
    /// Number of points.
    pub(super) fn points(&self) -> usize {
        self.area.map_or(1, |area| area.points.size().pow(2))
    }

    /// The points.
    pub(super) fn lights(&self) -> Vec<Light> {
        match self.area {
            None => vec![Light { position: self.position.as_vec3(), color: self.color }],
            Some(area) => rectangle(self.position, [area.u, area.v], area.points.size(), self.color).collect(),
        }
    }
}

/// Reads lights: at most [`MAX_LIGHTS`] points in all, and no area without a width.
pub(super) fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<LightSpec>, D::Error> {
    let lights = Vec::<LightSpec>::deserialize(from)?;
    let flat = |area: &AreaSpec| area.u.cross(area.v).length() < LENGTH.low * area.u.length().max(area.v.length());
    if lights.iter().any(|light| light.area.as_ref().is_some_and(flat)) {
        return Err(D::Error::custom("an area whose edges `u` and `v` are parallel is not allowed"));
    }
    check_count(lights.iter().map(LightSpec::points).sum()).map_err(D::Error::custom)?;
    Ok(lights)
}

/// An error if there are more than [`MAX_LIGHTS`] points.
pub(super) fn check_count(points: usize) -> Result<(), String> {
    if points <= MAX_LIGHTS {
        Ok(())
    } else {
        Err(format!("lights of {points} points: at most {MAX_LIGHTS} points are allowed"))
    }
}
