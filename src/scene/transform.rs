//! Transforms of points and of normals.

use glam::{DAffine3, DMat3, DVec3};

/// A transform of points, with its transform of normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transform {
    points: DAffine3,
    normals: DMat3,
}

impl Transform {
    /// Prepares `points` for use. Cofactors replace the inverse transpose: they give the same directions, and exist for
    /// a flattening transform, too.
    pub(super) fn new(points: DAffine3) -> Self {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = points.matrix3;
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        Self { points, normals: cofactors * points.matrix3.determinant().signum() }
    }

    /// The point after the transform.
    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.points.transform_point3(point)
    }

    /// The normal after the transform, up to a positive factor.
    pub(super) fn scaled_normal(&self, normal: DVec3) -> DVec3 {
        self.normals * normal
    }

    /// The unit normal after the transform; zero if it has no direction.
    pub(super) fn normal(&self, normal: DVec3) -> DVec3 {
        self.scaled_normal(normal).normalize_or_zero()
    }
}
