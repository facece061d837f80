//! How surfaces look.

use glam::Vec3;

/// An index into [`Scene::materials`](super::Scene::materials).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MaterialId(pub u32);

/// An index into [`Scene::textures`](super::Scene::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// A surface's looks (NFF and AFF `fm` terms). Colours are linear factors of 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Share of the ambient light that is reflected.
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
    /// Whether it only mirrors: point lights do not light it, so it needs no shadow rays.
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
