//! Point lights.

use glam::Vec3;

/// The largest number of lights that a scene can have: [`ShadowBits`](super::ShadowBits) has a bit for each.
pub const MAX_LIGHTS: usize = 64;

/// A point light without attenuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it is.
    pub position: Vec3,
    /// Its colour and strength.
    pub color: Vec3,
}
