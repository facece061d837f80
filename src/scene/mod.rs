//! Scenes: static and moving triangles, lights, a camera and materials, at the time of a frame.
//!
//! All positions are world space in `f32`, rounded once from `f64`, so that the tracer and the `f64` reference renderer
//! start from the same numbers.

pub mod aff;
pub mod builtin;
pub(crate) mod camera;
pub(crate) mod composed;
mod error;
mod fields;
mod frame;
mod geometry;
mod gltf;
pub(crate) mod keyframes;
pub mod lamps;
mod light;
mod limits;
mod loader;
mod material;
mod model;
mod obj;
pub(crate) mod parts;
pub(crate) mod path;
mod ply;
mod polygon;
pub(crate) mod render;
pub mod spec;
pub(crate) mod tessellate;
mod text;
mod texture;
mod transform;

pub use camera::{Camera, PixelRay, Projection};
pub use error::SceneError;
pub use frame::{Animation, Frame, Origin, Scene};
pub use geometry::{Attributes, Geometry, Triangle};
pub use lamps::Lamps;
pub use light::{Light, MAX_LIGHTS};
pub use material::{Material, MaterialId, Texture, TextureId};
pub use render::{Offset, Picture, RenderSpec, ShadowBits, ShadowRays};
