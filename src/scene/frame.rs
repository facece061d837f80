//! A scene: its static part, and its state at each frame.

use std::fmt;

use glam::Vec3;

use super::camera::Camera;
use super::geometry::{Attributes, Geometry, Triangle};
use super::lamps::Lamps;
use super::light::Light;
use super::material::{Material, Texture};
use crate::input::Source;
use crate::quantity::PrimitiveId;

/// The changing part of a scene at one frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The frame's number in the scene.
    pub number: u32,
    /// The camera.
    pub camera: Camera,
    /// The lights; their number is the same in every frame.
    pub lights: Vec<Light>,
    /// The triangles that can move: always [`Scene::dynamic_count`] of them, in the same order.
    pub dynamic: Geometry,
    /// Whether each dynamic triangle is present (visibility keys).
    pub visible: Vec<bool>,
}

/// Computes the changing part of a scene at a frame.
pub trait Animation: Send + Sync {
    /// The changing part at frame `number`.
    fn frame(&self, number: u32) -> Frame;
}

/// Where a scene comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// Every file that was read for the scene, with a hash of its bytes.
    pub sources: Vec<Source>,
    /// Contents of the files that have no effect here, each as a sentence for the user.
    pub notices: Vec<String>,
}

/// A scene: the static part, and the [`Animation`] of the moving part.
pub struct Scene {
    /// Its name in reports.
    pub name: String,
    /// Triangles that never move.
    pub statics: Geometry,
    /// Number of triangles that can move.
    pub dynamic_count: usize,
    /// Number of point lights.
    pub light_count: usize,
    /// Which lights belong to the same lamp.
    pub lamps: Lamps,
    /// Number of frames of the animation; frame numbers start at 0.
    pub frame_count: u32,
    /// All materials.
    pub materials: Vec<Material>,
    /// All textures.
    pub textures: Vec<Texture>,
    /// Colour of rays that hit nothing.
    pub background: Vec3,
    /// Ambient light.
    pub ambient: Vec3,
    /// The source files, and notices about contents without effect.
    pub origin: Origin,
    /// The moving part.
    pub animation: Box<dyn Animation>,
}

impl Scene {
    /// The number of primitives, static and dynamic.
    pub fn primitive_count(&self) -> usize {
        self.statics.len() + self.dynamic_count
    }

    /// Whether a primitive can move.
    pub fn is_dynamic(&self, primitive: PrimitiveId) -> bool {
        primitive.0 as usize >= self.statics.len()
    }

    /// A primitive's triangle at `frame`.
    pub fn triangle<'a>(&'a self, frame: &'a Frame, primitive: PrimitiveId) -> &'a Triangle {
        let index = primitive.0 as usize;
        match index.checked_sub(self.statics.len()) {
            None => &self.statics.triangles[index],
            Some(moving) => &frame.dynamic.triangles[moving],
        }
    }

    /// A primitive's attributes at `frame`.
    pub fn attributes<'a>(&'a self, frame: &'a Frame, primitive: PrimitiveId) -> &'a Attributes {
        let index = primitive.0 as usize;
        match index.checked_sub(self.statics.len()) {
            None => &self.statics.attributes[index],
            Some(moving) => &frame.dynamic.attributes[moving],
        }
    }
}

impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scene")
            .field("name", &self.name)
            .field("statics", &self.statics.len())
            .field("dynamic", &self.dynamic_count)
            .field("lights", &self.light_count)
            .finish_non_exhaustive()
    }
}
