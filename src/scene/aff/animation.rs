//! The moving part of an AFF scene: a tree of animated transforms, the triangles under it, lights and the camera.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use rayon::prelude::*;

use crate::scene::camera::Camera;
use crate::scene::frame::{Animation, Frame};
use crate::scene::geometry::{Attributes, Geometry, Triangle};
use crate::scene::keyframes::Motion;
use crate::scene::light::Light;
use crate::scene::material::MaterialId;
use crate::scene::transform::Transform;

/// The root of the tree of transforms: it never moves.
pub(super) const ROOT: usize = 0;

/// An animated transform.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The parent node; always an earlier one.
    pub parent: usize,
    /// The static transforms between the parent and the node's motion.
    pub place: DAffine3,
    /// The name of its keyframes, which may come later in the scene than the node.
    pub name: String,
}

/// Corners and normals of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    /// The corners.
    pub v: [DVec3; 3],
    /// The normals, of any length.
    pub normals: Option<[DVec3; 3]>,
}

impl Pose {
    /// The pose after a transform; normals by the inverse transpose, up to a positive factor.
    pub(super) fn transformed(&self, by: &Transform) -> Self {
        Self {
            v: self.v.map(|point| by.point(point)),
            normals: self.normals.map(|normals| normals.map(|normal| by.scaled_normal(normal))),
        }
    }

    /// Rounded for the tracer. Normals get unit length; if a normal has no length, the triangle shades flat.
    pub(super) fn rounded(&self) -> (Triangle, Option<[Vec3; 3]>) {
        let unit = self.normals.map(|normals| normals.map(DVec3::normalize_or_zero));
        let normals = unit.filter(|normals| !normals.contains(&DVec3::ZERO));
        (Triangle { v: self.v.map(|point| point.as_vec3()) }, normals.map(|normals| normals.map(|n| n.as_vec3())))
    }

    fn lerp(&self, other: &Self, share: f64) -> Self {
        let mix = |a: [DVec3; 3], b: [DVec3; 3]| [0, 1, 2].map(|corner| a[corner].lerp(b[corner], share));
        Self { v: mix(self.v, other.v), normals: self.normals.zip(other.normals).map(|(a, b)| mix(a, b)) }
    }
}

/// How a triangle moves within its node.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// Not at all.
    Rigid(Pose),
    /// Interpolated between poses (`tpa`): times in seconds, at least one.
    Morph(Box<[(f64, Pose)]>),
}

impl Shape {
    /// All poses of the shape.
    pub(super) fn poses(&self) -> impl Iterator<Item = &Pose> {
        let (rigid, morph) = match self {
            Self::Rigid(pose) => (Some(pose), &[][..]),
            Self::Morph(keys) => (None, &keys[..]),
        };
        rigid.into_iter().chain(morph.iter().map(|(_, pose)| pose))
    }

    /// Linear between keys, constant before the first and after the last. Of several keys at one time the last counts.
    fn at(&self, time: f64) -> Pose {
        let keys = match self {
            Self::Rigid(pose) => return *pose,
            Self::Morph(keys) => keys,
        };
        let next = keys.iter().position(|&(start, _)| time < start).unwrap_or(keys.len());
        let &(from, ref before) = &keys[next.saturating_sub(1)];
        match keys.get(next) {
            Some((to, after)) if next > 0 => before.lerp(after, (time - from) / (to - from)),
            _ => *before,
        }
    }
}

/// A triangle that can move.
#[derive(Clone, Debug)]
pub(super) struct Moving {
    /// The node that it belongs to.
    pub node: usize,
    /// Its pose in the node.
    pub shape: Shape,
    /// Its texture coordinates.
    pub uv: [Vec2; 3],
    /// Its material.
    pub material: MaterialId,
}

/// A point light that may move.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    /// Where it is before its motion.
    pub position: DVec3,
    /// Its colour.
    pub color: Vec3,
    /// The name of its keyframes, if it is animated.
    pub name: Option<String>,
}

/// The times of the frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Times {
    /// The first frame's time in seconds.
    pub start: f64,
    /// The last frame's time in seconds.
    pub end: f64,
    /// Number of frames, at least one.
    pub frames: u32,
}

impl Times {
    /// The time of a frame in seconds.
    pub(super) fn of(self, frame: u32) -> f64 {
        let last = self.frames.saturating_sub(1).max(1);
        self.start + f64::from(frame) * (self.end - self.start) / f64::from(last)
    }
}

/// The camera as the command `v` gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    /// The eye.
    pub eye: DVec3,
    /// Where it looks.
    pub direction: DVec3,
    /// What is up in the picture.
    pub up: DVec3,
    /// The full vertical field of view in radians.
    pub fov: f64,
}

/// The [`Animation`] of an AFF scene. Names are resolved to motions; an object without keyframes has a motion that
/// stands still.
#[derive(Debug)]
pub(super) struct AffAnimation {
    /// The tree, [`ROOT`] first, and each node's motion.
    pub nodes: Vec<(Node, Motion)>,
    /// The triangles, in the order of the file.
    pub moving: Vec<Moving>,
    /// The lights and their motion.
    pub lamps: Vec<(Lamp, Motion)>,
    /// The camera without its motion.
    pub view: View,
    /// The motion of the camera.
    pub camera: Motion,
    /// The times of the frames.
    pub times: Times,
}

impl AffAnimation {
    /// The camera at a time in seconds. Its keyframes give position and rotation; it looks along -z, its y axis is up.
    fn camera_at(&self, time: f64) -> Camera {
        let eye = self.camera.translation.as_ref().map_or(self.view.eye, |track| track.at(time));
        let axes = self.camera.rotation.as_ref().map(|track| track.at(time));
        let (direction, up) = axes.map_or((self.view.direction, self.view.up), |axes| (-axes.z_axis, axes.y_axis));
        Camera::perspective(eye, direction, up, self.view.fov)
    }

    /// World transform and visibility of each node.
    fn poses(&self, time: f64) -> Vec<(Transform, bool)> {
        let mut worlds: Vec<(DAffine3, bool)> = Vec::with_capacity(self.nodes.len());
        for (node, motion) in &self.nodes {
            let (parent, shown) = worlds.get(node.parent).copied().unwrap_or((DAffine3::IDENTITY, true));
            worlds.push((parent * node.place * motion.transform(time), shown && motion.visible(time)));
        }
        worlds.into_iter().map(|(world, shown)| (Transform::new(world), shown)).collect()
    }

    /// An upper bound, not tight, of the distance of anything from the origin at any time.
    pub(super) fn reach(&self) -> f64 {
        let mut radius = vec![0.0_f64; self.nodes.len()];
        for moving in &self.moving {
            let corners = moving.shape.poses().flat_map(|pose| pose.v);
            radius[moving.node] = corners.map(DVec3::length).fold(radius[moving.node], f64::max);
        }
        // Children come after their parents.
        for (index, (node, motion)) in self.nodes.iter().enumerate().skip(1).rev() {
            let child = stretch(node.place.matrix3) * motion.reach(radius[index]) + node.place.translation.length();
            radius[node.parent] = radius[node.parent].max(child);
        }
        let lamps = self.lamps.iter().map(|(lamp, motion)| motion.reach(lamp.position.length()));
        let camera = self.camera.reach(self.view.eye.length());
        lamps.fold(radius[ROOT].max(camera), f64::max)
    }
}

/// An upper bound of the factor by which `m` lengthens a vector; exact if the axes of `m` are at right angles.
fn stretch(m: DMat3) -> f64 {
    // Gershgorin's circles of m^T m, whose largest eigenvalue is the square of the factor.
    let squares = m.transpose() * m;
    [squares.x_axis, squares.y_axis, squares.z_axis]
        .map(|row| row.abs().element_sum())
        .into_iter()
        .fold(0.0, f64::max)
        .sqrt()
}

impl Animation for AffAnimation {
    fn frame(&self, number: u32) -> Frame {
        let time = self.times.of(number);
        let poses = self.poses(time);
        let (mut triangles, mut attributes) = (Vec::new(), Vec::new());
        let placed = self.moving.par_iter().with_min_len(4096).map(|moving| {
            let (triangle, normals) = moving.shape.at(time).transformed(&poses[moving.node].0).rounded();
            (triangle, Attributes { normals, uv: moving.uv, material: moving.material })
        });
        placed.unzip_into_vecs(&mut triangles, &mut attributes);
        let lights = self.lamps.iter().map(|(lamp, motion)| Light {
            position: motion.transform(time).transform_point3(lamp.position).as_vec3(),
            color: lamp.color,
        });
        Frame {
            number,
            camera: self.camera_at(time),
            lights: lights.collect(),
            dynamic: Geometry { triangles, attributes },
            visible: self.moving.iter().map(|moving| poses[moving.node].1).collect(),
        }
    }
}
