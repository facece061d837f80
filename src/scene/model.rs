//! The contents of a file of triangles, placed in the world.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use super::camera::{Camera, Projection};
use super::error::SceneError;
use super::geometry::{Attributes, Geometry, Triangle};
use super::limits;
use super::transform::Transform;

/// A pose at a time in seconds: the transform from an object's own space to the world.
pub(super) type PoseAt = Arc<dyn Fn(f64) -> DAffine3 + Send + Sync>;

/// The contents of a file.
#[derive(Default)]
pub(super) struct Model {
    /// Triangles that never move, in the world.
    pub statics: Geometry,
    /// Triangles that move, in their own space, and their poses.
    pub moving: Vec<(Geometry, PoseAt)>,
    /// Cameras.
    pub cameras: Vec<FileCamera>,
    /// Lights.
    pub lights: Vec<FileLight>,
}

/// A camera of a file; it looks along -z, y is up.
pub(super) struct FileCamera {
    /// Its name.
    pub name: String,
    /// How it maps pixels to rays; a parallel projection takes the camera's direction.
    pub projection: Projection,
    /// Where it is.
    pub pose: PoseAt,
}

impl FileCamera {
    /// The camera at a time in seconds.
    pub(super) fn at(&self, time: f64) -> Camera {
        let pose = (self.pose)(time);
        let axes = pose.matrix3;
        let camera = Camera::perspective(pose.translation, -axes.z_axis, axes.y_axis, 1.0);
        let projection = match self.projection {
            Projection::Parallel { half_height, .. } => Projection::Parallel { half_height, direction: camera.forward },
            perspective => perspective,
        };
        Camera { projection, ..camera }
    }
}

/// A point light of a file.
pub(super) struct FileLight {
    /// Its colour and strength.
    pub color: Vec3,
    /// Where it is.
    pub pose: PoseAt,
    /// Whether it moves.
    pub moves: bool,
}

impl Model {
    /// The model of a file in which nothing moves; `geometry` is in the file's space.
    ///
    /// # Errors
    /// A corner that is too far from the origin.
    pub(super) fn still(geometry: Geometry, place: DAffine3, path: &Path) -> Result<Self, SceneError> {
        let mut statics = Geometry::default();
        append(&mut statics, &geometry, place).map_err(|what| SceneError::Content { path: path.to_owned(), what })?;
        Ok(Self { statics, ..Self::default() })
    }
}

/// Adds `part`, placed by `place`, to `whole`. Computed in `f64` and rounded once.
///
/// # Errors
/// A corner that is too far from the origin, or too many triangles.
pub(super) fn append(whole: &mut Geometry, part: &Geometry, place: DAffine3) -> Result<(), String> {
    limits::check_count(whole.len() + part.len())?;
    let transform = Transform::new(place);
    for (triangle, attributes) in part.triangles.iter().zip(&part.attributes) {
        if place == DAffine3::IDENTITY {
            whole.push(*triangle, *attributes);
            continue;
        }
        let corners = triangle.v.map(|corner| transform.point(corner.as_dvec3()));
        corners.into_iter().try_for_each(|corner| limits::check_reach(corner).map(|_| ()))?;
        let normals = attributes.normals.map(|normals| normals.map(|normal| transform.normal(normal.as_dvec3())));
        // A transform that flattens leaves a normal without a direction; the triangle then shades flat.
        let normals = normals.filter(|normals| !normals.contains(&DVec3::ZERO));
        let normals = normals.map(|normals| normals.map(|normal| normal.as_vec3()));
        whole.push(Triangle { v: corners.map(|corner| corner.as_vec3()) }, Attributes { normals, ..*attributes });
    }
    Ok(())
}
