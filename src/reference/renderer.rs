//! Renders a frame, row by row.

use rayon::prelude::*;

use super::bvh::Tree;
use super::frame::ReferenceFrame;
use super::shade::Shader;
use crate::quantity::{PrimitiveId, Resolution};
use crate::scene::{Frame, Geometry, Picture, RenderSpec, Scene, Triangle};

/// The reference renderer of a scene; holds the tree of the static triangles.
pub struct Reference<'a> {
    scene: &'a Scene,
    statics: Tree,
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

    /// Renders `frame`; `offset` is the offset of `spec` in world units. The picture does not depend on the number of
    /// threads.
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
