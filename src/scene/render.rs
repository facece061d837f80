//! Types of pictures and of their settings, which the tracer and the reference renderer share. They share no rendering
//! code.

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::frame::{Frame, Scene};
use super::limits::MAX_REACH;
use crate::quantity::{PrimitiveId, Resolution};

/// How pictures are rendered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RenderSpec {
    /// Maximum ray depth, counted from the primary ray: 1 traces no secondary rays. GI09 uses 10.
    #[serde(deserialize_with = "depth")]
    #[schemars(range(min = 1, max = 32))]
    pub depth: u32,
    /// Which lights get a shadow ray from a hit.
    pub shadow_rays: ShadowRays,
    /// Distance between the surface and the origin of a shadow or secondary ray, along the geometric normal.
    pub offset: Offset,
    /// Secondary rays with a smaller weight in the picture are not traced (Hall and Greenberg 1983). Effect of the
    /// default at depth 10: docs/validation/paper.md.
    #[serde(deserialize_with = "weight")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_weight: f32,
}

impl Default for RenderSpec {
    fn default() -> Self {
        Self { depth: 1, shadow_rays: ShadowRays::ViewerSide, offset: Offset::Relative(1e-5), min_weight: 1.0 / 256.0 }
    }
}

fn depth<'de, D: serde::Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    let depth = u32::deserialize(from)?;
    if (1..=32).contains(&depth) {
        Ok(depth)
    } else {
        Err(serde::de::Error::custom(format!("`depth` is {depth}: a whole number from 1 to 32 is allowed")))
    }
}

fn weight<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f32, D::Error> {
    let weight = f32::deserialize(from)?;
    if (0.0..=1.0).contains(&weight) {
        Ok(weight)
    } else {
        Err(serde::de::Error::custom(format!("`min_weight` is {weight}: a number from 0 to 1 is allowed")))
    }
}

/// Which lights get a shadow ray from a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ShadowRays {
    /// Lights on the viewer's side of the surface: other lights cannot light the visible side.
    ViewerSide,
    /// All lights.
    Always,
}

/// Distance between a surface and the origin of a ray that starts on it. A positive number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum Offset {
    /// In world units.
    Absolute(#[serde(deserialize_with = "length")] f64),
    /// As a share of the diagonal of the bounding box of the static triangles (of all triangles if none is static).
    Relative(#[serde(deserialize_with = "length")] f64),
}

fn length<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let length = f64::deserialize(from)?;
    if length > 0.0 && length <= MAX_REACH {
        Ok(length)
    } else {
        Err(serde::de::Error::custom(format!(
            "an offset of {length}: a number above 0, at most {MAX_REACH:e}, is allowed"
        )))
    }
}

impl Offset {
    /// The offset in world units; `frame` is the experiment's first frame.
    pub fn resolve(self, scene: &Scene, frame: &Frame) -> f64 {
        match self {
            Self::Absolute(length) => length,
            Self::Relative(share) => {
                let of = if scene.statics.is_empty() { &frame.dynamic } else { &scene.statics };
                let corners = of.triangles.iter().flat_map(|triangle| triangle.v);
                let (low, high) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), corner| {
                    (low.min(corner), high.max(corner))
                });
                if of.is_empty() { share } else { share * (high - low).as_dvec3().length() }
            }
        }
    }
}

/// The shadow rays of a pixel's primary hit, one bit per light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowBits {
    /// Lights for which the hit asked for a shadow ray.
    pub asked: u64,
    /// Lights that are hidden from the hit.
    pub dark: u64,
}

/// A traced picture, pixel by pixel from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Its size.
    pub resolution: Resolution,
    /// Linear colour.
    pub rgb: Vec<Vec3>,
    /// What the primary ray hit.
    pub hits: Vec<Option<PrimitiveId>>,
    /// The shadow rays of the primary hit.
    pub shadows: Vec<ShadowBits>,
}
