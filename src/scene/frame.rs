//! A scene, and what of it changes from frame to frame.

use std::fmt;

use glam::Vec3;

use super::camera::Camera;
use super::geometry::{Attributes, Geometry, Triangle};
use super::lamps::Lamps;
use super::light::Light;
use super::material::{Material, Texture};
use crate::input::Source;
use crate::quantity::PrimitiveId;

/// Everything of a scene that changes with time, at one frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The frame's number, as the scene counts.
    pub number: u32,
    /// The camera.
    pub camera: Camera,
    /// The lights; their number is the same in every frame.
    pub lights: Vec<Light>,
    /// The triangles that can move: always [`Scene::dynamic_count`] of them, in the same order.
    pub dynamic: Geometry,
    /// Which of them are there at all (visibility keys), as many as there are dynamic triangles.
    pub visible: Vec<bool>,
}

/// What moves: gives the changing part of the scene at a frame.
pub trait Animation: Send + Sync {
    /// The changing part at frame `number`.
    fn frame(&self, number: u32) -> Frame;
}

/// Where a scene comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// Every file that was read for the scene, with a hash of its bytes.
    pub sources: Vec<Source>,
    /// What stands in the files and has no effect here, each a sentence for the user.
    pub notices: Vec<String>,
}

/// A scene: what stays, and the [`Animation`] of what moves.
pub struct Scene {
    /// Its name in reports.
    pub name: String,
    /// Triangles that never move.
    pub statics: Geometry,
    /// How many triangles can move.
    pub dynamic_count: usize,
    /// How many lights there are: points that shine.
    pub light_count: usize,
    /// Which of them belong to one lamp.
    pub lamps: Lamps,
    /// How many frames the animation has; frame numbers run from 0 to one less.
    pub frame_count: u32,
    /// All materials.
    pub materials: Vec<Material>,
    /// All textures.
    pub textures: Vec<Texture>,
    /// Colour of rays that hit nothing.
    pub background: Vec3,
    /// Ambient light.
    pub ambient: Vec3,
    /// The files that it was read from, and what of them has no effect.
    pub origin: Origin,
    /// What moves.
    pub animation: Box<dyn Animation>,
}

impl Scene {
    /// The number of primitives, static and dynamic.
    pub fn primitive_count(&self) -> usize {
        self.statics.len() + self.dynamic_count
    }

    /// Whether a primitive is of the part that can move.
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
