//! Triangles, and their attributes for shading.

use glam::{Vec2, Vec3};

use super::material::MaterialId;

/// A triangle in world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Triangle {
    /// The corners.
    pub v: [Vec3; 3],
}

impl Triangle {
    /// The cross product of two edges. Its length is twice the area; it points to the counter-clockwise side.
    pub fn normal(&self) -> Vec3 {
        (self.v[1] - self.v[0]).cross(self.v[2] - self.v[0])
    }
}

/// Attributes of a triangle for shading; intersection never reads them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Unit normals at the corners in world space; `None` shades with the geometric normal.
    pub normals: Option<[Vec3; 3]>,
    /// Texture coordinates at the corners; repeated outside 0..1.
    pub uv: [Vec2; 3],
    /// The material.
    pub material: MaterialId,
}

/// Triangles, and attributes with the same indices.
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
