//! Cameras: where the ray of a pixel starts and where it goes.

use glam::{DVec2, DVec3};

use crate::quantity::Resolution;

/// How a camera maps pixels to rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays start at the eye.
    Perspective {
        /// Tangent of half the vertical field of view.
        tan_half_fov: f64,
    },
    /// All rays run in one direction, from a plane through the eye.
    Parallel {
        /// Half the height of the window, in world units.
        half_height: f64,
        /// The direction of the rays; it need not be at right angles to the window.
        direction: DVec3,
    },
}

/// A camera at one frame. Pixels are square: the window's width follows from the resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye, or the window's centre for a parallel projection.
    pub eye: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// How pixels map to rays.
    pub projection: Projection,
    /// Shift of every sample from its pixel's centre, in pixels to the right and upwards.
    pub jitter: DVec2,
}

/// The ray of a pixel; the direction is not of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRay {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes.
    pub direction: DVec3,
}

impl Camera {
    /// A perspective camera at `eye` that looks along `direction`; `fov` is the full vertical field of view in radians.
    pub fn perspective(eye: DVec3, direction: DVec3, up: DVec3, fov: f64) -> Self {
        let forward = direction.normalize();
        let right = forward.cross(up).normalize();
        Self {
            eye,
            right,
            up: right.cross(forward),
            forward,
            projection: Projection::Perspective { tan_half_fov: (0.5 * fov).tan() },
            jitter: DVec2::ZERO,
        }
    }

    /// The ray through the sample of pixel (`x`, `y`), counted from the top left.
    pub fn ray(&self, resolution: Resolution, x: u32, y: u32) -> PixelRay {
        let (width, height) = (f64::from(resolution.width), f64::from(resolution.height));
        // From -1 at the bottom to 1 at the top; one pixel is 2/height in both directions.
        let across = (2.0 * (f64::from(x) + 0.5 + self.jitter.x) - width) / height;
        let upward = (height - 2.0 * (f64::from(y) + 0.5 - self.jitter.y)) / height;
        let offset = self.right * across + self.up * upward;
        match self.projection {
            Projection::Perspective { tan_half_fov } => {
                PixelRay { origin: self.eye, direction: self.forward + offset * tan_half_fov }
            }
            Projection::Parallel { half_height, direction } => {
                PixelRay { origin: self.eye + offset * half_height, direction }
            }
        }
    }
}
