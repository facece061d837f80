//! The reference renderer: plain, in `f64`, without culling, and with nothing in common with the tracer but the scene.
//!
//! The tracer follows the same rules in `f32`:
//!
//! - **Primary rays** come from [`Camera::ray`](crate::scene::Camera::ray). A ray hits the triangle with the least t > 0,
//!   from either side; at equal t the lowest [`PrimitiveId`] wins. A triangle without area cannot be hit. Dynamic
//!   triangles count while they are visible.
//! - **Start points.** The geometric normal is turned to the viewer. Shadow and reflected rays start at the hit point
//!   plus `offset` times that normal, refracted ones at the hit point minus it.
//! - **Shadow rays.** [`ShadowRays::ViewerSide`](crate::scene::ShadowRays) asks for a light if (light - hit point).normal is
//!   above 0, `Always` asks for all; a [perfect mirror](crate::scene::Material::is_perfect_mirror) asks for none. A light is
//!   hidden if any triangle meets the segment from the start point to the light,
//!   both ends left out. Both sides of a triangle block; transparency is ignored.
//! - **Shading** is in linear colour. N is the normal interpolated between the corners, of unit length and turned to the
//!   side of the geometric one; the geometric one where there are none or where they cancel out. The sum of
//!   `scene.ambient * ambient * texture` and, for each light that is asked for, lit and on the viewer's side,
//!   `color * (diffuse * texture * max(0, N.L) + specular * max(0, R.V)^shininess)`, the second only if N.L > 0
//!   (Phong 1975). Textures give their nearest pixel, repeat outside 0..1, have v upwards; a byte is a linear 255th.
//! - **Secondary rays** (Whitted 1980) are traced while fewer than `depth` rays are in a row. The reflected ray's weight
//!   is `specular`, the refracted one's is `transmittance`. A ray enters the medium where it meets a counter-clockwise
//!   side. Total internal reflection adds the transmittance to the reflected ray's weight. A ray is traced if the largest
//!   component of the product of weights on its way is above 0 and not below `min_weight`. A miss gives the background.

mod bvh;
mod ray;
mod shade;

use glam::DVec3;
use rayon::prelude::*;

use self::bvh::Tree;
use self::ray::Ray;
use self::shade::Shader;
use crate::quantity::{PrimitiveId, Resolution};
use crate::scene::{Frame, Geometry, Picture, RenderSpec, Scene, Triangle};

/// The reference renderer of a scene; holds the tree of the static triangles.
pub struct Reference<'a> {
    scene: &'a Scene,
    statics: Tree,
}

/// A scene at a frame, ready for rays.
pub struct ReferenceFrame<'a> {
    scene: &'a Scene,
    frame: &'a Frame,
    statics: &'a Tree,
    dynamic: Tree,
    /// The largest coordinate of a triangle.
    reach: f64,
}

/// Where a ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where on the ray, in lengths of its direction.
    pub t: f64,
    /// What it hits.
    pub primitive: PrimitiveId,
    /// The weights of the triangle's corners at the hit point.
    pub weights: [f64; 3],
}

impl<'a> Reference<'a> {
    /// Builds the tree of the static triangles.
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, statics: Tree::new(numbered(&scene.statics, 0)) }
    }

    /// Builds the tree of the visible dynamic triangles of `frame`.
    pub fn frame<'f>(&'f self, frame: &'f Frame) -> ReferenceFrame<'f> {
        let moving = numbered(&frame.dynamic, self.scene.statics.len());
        let visible = moving.zip(&frame.visible).filter(|(_, visible)| **visible).map(|(triangle, _)| triangle);
        let dynamic = Tree::new(visible);
        let reach = self.statics.reach().max(dynamic.reach());
        ReferenceFrame { scene: self.scene, frame, statics: &self.statics, dynamic, reach }
    }

    /// Renders `frame`; `offset` is that of `spec` in world units. The picture does not depend on the number of threads.
    ///
    /// The scene has at most [`MAX_LIGHTS`](crate::scene::MAX_LIGHTS) lights.
    pub fn render(&self, frame: &Frame, resolution: Resolution, spec: &RenderSpec, offset: f64) -> Picture {
        let traced = self.frame(frame);
        let shader = Shader { frame: &traced, spec, offset };
        let rows: Vec<Vec<_>> = (0..resolution.height)
            .into_par_iter()
            .map(|y| (0..resolution.width).map(|x| shader.pixel(frame.camera.ray(resolution, x, y))).collect())
            .collect();
        let mut picture = Picture { resolution, rgb: Vec::new(), hits: Vec::new(), shadows: Vec::new() };
        for (rgb, hit, shadows) in rows.into_iter().flatten() {
            picture.rgb.push(rgb);
            picture.hits.push(hit);
            picture.shadows.push(shadows);
        }
        picture
    }
}

fn numbered(geometry: &Geometry, first: usize) -> impl Iterator<Item = (PrimitiveId, Triangle)> {
    geometry.triangles.iter().enumerate().map(move |(index, triangle)| (PrimitiveId((first + index) as u32), *triangle))
}

impl ReferenceFrame<'_> {
    /// The nearest hit with t > 0 of the ray from `origin` along `direction` (of any length).
    pub fn closest(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(origin, direction, f64::INFINITY, |hit| {
            if best.is_none_or(|best| (hit.t, hit.primitive) < (best.t, best.primitive)) {
                best = Some(hit);
            }
            best.map_or(f64::INFINITY, |best| best.t)
        });
        best
    }

    /// Whether any triangle meets the segment from `origin` to `target`, both ends left out.
    pub fn occluded(&self, origin: DVec3, target: DVec3) -> bool {
        let mut blocked = false;
        self.walk(origin, target - origin, 1.0, |hit| {
            blocked |= hit.t < 1.0;
            if blocked { f64::NEG_INFINITY } else { 1.0 }
        });
        blocked
    }

    fn walk(&self, origin: DVec3, direction: DVec3, mut limit: f64, mut visit: impl FnMut(Hit) -> f64) {
        if !direction.is_finite() {
            return;
        }
        let ray = Ray::new(origin, direction, self.reach);
        for tree in [self.statics, &self.dynamic] {
            tree.walk(&ray, limit, |primitive, crossing| {
                limit = visit(Hit { t: crossing.t, primitive, weights: crossing.weights });
                limit
            });
        }
    }
}

#[cfg(test)]
mod tests;
