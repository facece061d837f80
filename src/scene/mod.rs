//! Scenes: triangles that stay, triangles that move, lights, a camera and materials, as they are at a frame's time.
//!
//! All positions are world space in `f32`, rounded once from `f64`, so that the tracer and the `f64` reference renderer
//! start from the same numbers.

pub mod aff;
pub mod builtin;
pub mod camera;
mod fields;

pub mod keyframes;
pub mod lamps;
pub mod obj;
pub mod parts;
pub mod path;
pub mod render;
pub mod spec;
pub mod tessellate;
pub mod texture;

use std::fmt;
use std::path::PathBuf;

use glam::{Vec2, Vec3};

pub use camera::{Camera, PixelRay, Projection};
pub use lamps::Lamps;
pub use render::{Offset, Picture, RenderSpec, ShadowBits, ShadowRays};

use crate::quantity::PrimitiveId;

/// A triangle in world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Triangle {
    /// The corners.
    pub v: [Vec3; 3],
}

impl Triangle {
    /// The cross product of two edges: twice the area long, counter-clockwise side up.
    pub fn normal(&self) -> Vec3 {
        (self.v[1] - self.v[0]).cross(self.v[2] - self.v[0])
    }
}

/// An index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// An index into [`Scene::textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// What shading needs of a triangle; intersection never reads it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Unit normals at the corners in world space; `None` shades with the geometric normal.
    pub normals: Option<[Vec3; 3]>,
    /// Texture coordinates at the corners; repeated outside 0..1.
    pub uv: [Vec2; 3],
    /// The material.
    pub material: MaterialId,
}

/// Triangles and their attributes, index by index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// The triangles.
    pub triangles: Vec<Triangle>,
    /// Their attributes, as many as there are triangles.
    pub attributes: Vec<Attributes>,
}

impl Geometry {
    /// Adds a triangle.
    pub fn push(&mut self, triangle: Triangle, attributes: Attributes) {
        self.triangles.push(triangle);
        self.attributes.push(attributes);
    }

    /// The number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }
}

/// A surface's looks (NFF and AFF `fm` terms). Colours are linear factors of 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Share of the ambient light that is sent back.
    pub ambient: Vec3,
    /// Lambert reflectance; a texture multiplies it.
    pub diffuse: Vec3,
    /// Phong highlight colour, and the weight of the reflected ray.
    pub specular: Vec3,
    /// Phong exponent; infinite for a perfect mirror, which shows no highlight of a point.
    pub shininess: f32,
    /// Weight of the refracted ray, 0 for opaque.
    pub transmittance: f32,
    /// Index of refraction.
    pub index_of_refraction: f32,
    /// A picture that colours the surface.
    pub texture: Option<TextureId>,
}

impl Material {
    /// Whether it only mirrors: nothing of it is lit by a point light, so no shadow ray is asked for.
    pub fn is_perfect_mirror(&self) -> bool {
        self.diffuse == Vec3::ZERO && self.specular != Vec3::ZERO && self.shininess.is_infinite()
    }
}

impl Default for Material {
    /// A matt light grey.
    fn default() -> Self {
        Self {
            ambient: Vec3::splat(0.1),
            diffuse: Vec3::splat(0.7),
            specular: Vec3::ZERO,
            shininess: 1.0,
            transmittance: 0.0,
            index_of_refraction: 1.0,
            texture: None,
        }
    }
}

/// A picture that colours surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows, the first at v = 1.
    pub height: u32,
    /// Red, green and blue, row by row from the top left.
    pub rgb: Vec<[u8; 3]>,
}

/// A point light without attenuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it is.
    pub position: Vec3,
    /// Its colour and strength.
    pub color: Vec3,
}

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

/// Why a scene cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file's text is not of its format.
    #[error("{}:{line}: {what}", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// The file is of its format, and yet no scene.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}
