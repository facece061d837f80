//! The reference renderer: simple, in `f64`, without culling. It shares only the scene with the tracer.
//!
//! The tracer follows the same rules in `f32`:
//!
//! - **Primary rays** come from [`Camera::ray`](crate::scene::Camera::ray). A ray hits the triangle with the least t >
//!   0, from either side; at equal t the lowest `PrimitiveId` wins. A triangle without area cannot be hit. Dynamic
//!   triangles count while they are visible.
//! - **Start points.** The geometric normal is turned to the viewer. Shadow and reflected rays start at the hit point
//!   plus `offset` times that normal, refracted rays at the hit point minus it.
//! - **Shadow rays.** [`ShadowRays::ViewerSide`](crate::scene::ShadowRays) asks for a light if (light - hit
//!   point).normal is above 0, `Always` asks for all; a [perfect mirror](crate::scene::Material::is_perfect_mirror)
//!   asks for none. A light is hidden if any triangle meets the segment from the start point to the light, both ends
//!   excluded. Both sides of a triangle block; transparency is ignored.
//! - **Shading** is in linear colour. N is the normal interpolated between the corners, of unit length and turned to
//!   the side of the geometric normal. Where the corners have no normals, or these cancel out, N is the geometric
//!   normal. The colour is the sum of `scene.ambient * ambient * texture` and of a term for each light that is asked
//!   for, visible and on the viewer's side: `color * (diffuse * texture * max(0, N.L) + specular * max(0,
//!   R.V)^shininess)`, with the specular part only if N.L > 0 (Phong 1975). Textures give their nearest pixel, repeat
//!   outside 0..1, and have v upwards; a byte is a linear 255th.
//! - **Secondary rays** (Whitted 1980) are traced while fewer than `depth` rays are in a row. The reflected ray's
//!   weight is `specular`, the refracted ray's is `transmittance`. A ray enters the medium where it meets a
//!   counter-clockwise side. Total internal reflection adds the transmittance to the reflected ray's weight. A ray is
//!   traced if the largest component of the product of weights on its way is above 0 and not below `min_weight`. A miss
//!   gives the background.

mod bvh;
mod frame;
mod ray;
mod renderer;
mod shade;

pub use self::frame::{Hit, ReferenceFrame};
pub use self::renderer::Reference;

#[cfg(test)]
mod tests;
