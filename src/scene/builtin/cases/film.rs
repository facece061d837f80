//! What all cases share: two materials, and an animation as a function.

use glam::Vec3;

use crate::scene::frame::{Animation, Frame};
use crate::scene::material::{Material, MaterialId};

/// Matt grey.
pub(super) const MATT: MaterialId = MaterialId(0);
/// A perfect mirror.
pub(super) const MIRROR: MaterialId = MaterialId(1);

/// The materials of all cases.
pub(super) fn palette() -> Vec<Material> {
    vec![
        Material::default(),
        Material {
            ambient: Vec3::ZERO,
            diffuse: Vec3::ZERO,
            specular: Vec3::ONE,
            shininess: f32::INFINITY,
            ..Material::default()
        },
    ]
}

/// An animation as a function of the frame's number.
pub(super) struct Film<F>(pub(super) F);

impl<F: Fn(u32) -> Frame + Send + Sync> Animation for Film<F> {
    fn frame(&self, number: u32) -> Frame {
        (self.0)(number)
    }
}
