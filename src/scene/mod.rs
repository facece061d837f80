//! Scenes: triangles that stay, triangles that move, lights, a camera and materials, as they are at a frame's time.
//!
//! All positions are world space in `f32`, rounded once from `f64`, so that the tracer and the `f64` reference renderer
//! start from the same numbers.

pub mod aff;
pub mod builtin;
pub mod camera;
pub mod composed;
mod error;
mod fields;
mod frame;
mod geometry;
mod gltf;
pub mod keyframes;
pub mod lamps;
mod light;
mod limits;
mod loader;
mod material;
mod model;
mod obj;
pub mod parts;
pub mod path;
mod ply;
mod polygon;
pub mod render;
pub mod spec;
pub mod tessellate;
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
