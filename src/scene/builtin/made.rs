//! The parts that a built-in scene's code makes, and the scene of these parts.

use glam::Vec3;

use super::paint::Palette;
use crate::ranged::Within;
use crate::scene::frame::{Origin, Scene};
use crate::scene::geometry::Geometry;
use crate::scene::lamps::Lamps;
use crate::scene::parts::Parts;

/// A number of frames.
pub(super) type Frames = Within<1, 1_000_000>;

/// The parts that a scene's code makes.
pub(super) struct Made {
    pub(super) statics: Geometry,
    pub(super) parts: Parts,
    pub(super) palette: Palette,
    pub(super) background: Vec3,
    pub(super) ambient: Vec3,
}

impl Made {
    /// The scene, with the name `name`.
    pub(super) fn into_scene(self, name: &str, frame_count: Frames) -> Scene {
        Scene {
            name: name.into(),
            statics: self.statics,
            dynamic_count: self.parts.triangle_count(),
            light_count: self.parts.lights.len(),
            lamps: Lamps::points(),
            frame_count: frame_count.get() as u32,
            materials: self.palette.materials,
            textures: self.palette.textures,
            background: self.background,
            ambient: self.ambient,
            origin: Origin::default(),
            animation: Box::new(self.parts),
        }
    }
}
