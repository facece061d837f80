//! An animation of rigid parts, each with its own motion.

use glam::{DAffine3, Vec3};

use super::camera::Camera;
use super::frame::{Animation, Frame};
use super::geometry::{Geometry, Triangle};
use super::light::Light;

/// A pose at a frame: the transform from a part's own space to the world.
pub(crate) type Pose = Box<dyn Fn(u32) -> DAffine3 + Send + Sync>;

/// Geometry that moves as a rigid body.
pub(crate) struct Part {
    /// The triangles in the part's own space.
    pub geometry: Geometry,
    /// Where it is.
    pub pose: Pose,
}

/// Parts, a camera and lights.
pub(crate) struct Parts {
    /// The moving parts.
    pub parts: Vec<Part>,
    /// Lights that stand still.
    pub lights: Vec<Light>,
    /// Lights that move, as functions of the frame; they follow the lights that stand still.
    pub carried: Vec<Box<dyn Fn(u32) -> Light + Send + Sync>>,
    /// The camera at a frame.
    pub camera: Box<dyn Fn(u32) -> Camera + Send + Sync>,
}

impl Parts {
    /// The number of triangles of all parts.
    pub(crate) fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.geometry.len()).sum()
    }
}

impl Animation for Parts {
    fn frame(&self, number: u32) -> Frame {
        let mut dynamic = Geometry::default();
        for part in &self.parts {
            append(&mut dynamic, &part.geometry, &(part.pose)(number));
        }
        let visible = vec![true; dynamic.len()];
        let carried = self.carried.iter().map(|light| light(number));
        let lights = self.lights.iter().copied().chain(carried).collect();
        Frame { number, camera: (self.camera)(number), lights, dynamic, visible }
    }
}

/// Adds `part`, placed by `pose`, to `whole`. Computed in `f64` and rounded once.
fn append(whole: &mut Geometry, part: &Geometry, pose: &DAffine3) {
    let upright = pose.matrix3.inverse().transpose();
    for (triangle, attributes) in part.triangles.iter().zip(&part.attributes) {
        let mut placed = *attributes;
        let normals = attributes.normals.map(|n| n.map(|n| (upright * n.as_dvec3()).normalize_or_zero().as_vec3()));
        // A pose that flattens leaves a normal without a direction; the triangle then shades flat.
        placed.normals = normals.filter(|normals| !normals.contains(&Vec3::ZERO));
        whole.push(Triangle { v: triangle.v.map(|v| pose.transform_point3(v.as_dvec3()).as_vec3()) }, placed);
    }
}
