//! Collects the definitions in the files of an AFF scene and builds the [`Scene`].

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DAffine3, Vec2, Vec3};
use rustc_hash::FxHashMap;

use super::animation::{AffAnimation, Lamp, Moving, Node, Pose, ROOT, Shape, Times, View};
use crate::scene::frame::Scene;
use crate::scene::geometry::{Attributes, Geometry};
use crate::scene::keyframes::Motion;
use crate::scene::lamps::Lamps;
use crate::scene::limits::{MAX_REACH, check_count, check_reach};
use crate::scene::loader::Loader;
use crate::scene::material::{Material, MaterialId, TextureId};
use crate::scene::texture;
use crate::scene::transform::Transform;

/// The space of shapes: a node, and static transforms below it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    /// The animated transform.
    pub node: usize,
    /// The static transforms.
    pub place: DAffine3,
}

/// A triangle as a file gives it.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Its pose, or its poses.
    pub shape: Shape,
    /// Its texture coordinates.
    pub uv: [Vec2; 3],
}

/// The scene so far.
pub(super) struct Builder {
    /// The files, materials and textures.
    pub loader: Loader,
    folder: PathBuf,
    statics: Geometry,
    moving: Vec<Moving>,
    /// The animated transforms, the root first.
    pub nodes: Vec<Node>,
    material_ids: FxHashMap<([u32; 12], Option<TextureId>), MaterialId>,
    texture_ids: BTreeMap<String, TextureId>,
    /// The keyframes by name.
    pub motions: BTreeMap<String, Motion>,
    /// The lights.
    pub lamps: Vec<Lamp>,
    /// The camera.
    pub view: Option<View>,
    /// The times of the frames.
    pub times: Times,
    /// Colour of rays that hit nothing.
    pub background: Vec3,
    /// Ambient light.
    pub ambient: Vec3,
}

impl Builder {
    /// An empty scene, whose files are in `folder`.
    pub(super) fn new(folder: PathBuf) -> Self {
        Self {
            loader: Loader::default(),
            folder,
            statics: Geometry::default(),
            moving: Vec::new(),
            nodes: vec![Node { parent: ROOT, place: DAffine3::IDENTITY, name: String::new() }],
            material_ids: FxHashMap::default(),
            texture_ids: BTreeMap::new(),
            motions: BTreeMap::new(),
            lamps: Vec::new(),
            view: None,
            times: Times { start: 0.0, end: 0.0, frames: 1 },
            background: Vec3::ZERO,
            ambient: Vec3::ONE,
        }
    }

    /// The folder that file names start from.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Opens an animated transform in `space`.
    pub(super) fn animate(&mut self, space: Space, name: String) -> Space {
        self.nodes.push(Node { parent: space.node, place: space.place, name });
        Space { node: self.nodes.len() - 1, place: DAffine3::IDENTITY }
    }

    /// The id of `material`; equal materials share an id.
    pub(super) fn material(&mut self, material: Material) -> MaterialId {
        let Material { ambient, diffuse, specular, shininess, transmittance, index_of_refraction, texture } = material;
        let [[a, b, c], [d, e, f], [g, h, i]] = [ambient, diffuse, specular].map(|color| color.to_array());
        let numbers = [a, b, c, d, e, f, g, h, i, shininess, transmittance, index_of_refraction].map(f32::to_bits);
        let loader = &mut self.loader;
        *self.material_ids.entry((numbers, texture)).or_insert_with(|| loader.add_material(material))
    }

    /// The id of the texture in file `name`, which is in the scene's folder or in `../textures`.
    ///
    /// BART's texture coordinates are OpenGL's for a picture in the file's order of rows: v = 0 is the file's first
    /// row. The kitchen's garden (sky at the top of the file, v = 0 at the top of the wall) and the robot's
    /// `signracer.ppm` (upside down in the file, v = 0 at the bottom of the sign) agree on that; of the toy car, only
    /// the licence plate comes out upside down. [`Texture`] has v = 1 at its first row, so the order of rows is
    /// reversed here.
    pub(super) fn texture(&mut self, name: &str) -> Result<TextureId, String> {
        if let Some(&id) = self.texture_ids.get(name) {
            return Ok(id);
        }
        let beside = self.folder.join(name);
        let path = if beside.exists() { beside } else { self.folder.join("../textures").join(name) };
        let wrong = |what: String| format!("texture `{name}`: {what}");
        let bytes = self.loader.files.read(&path);
        let bytes = bytes.map_err(|error| wrong(format!("cannot read {}: {error}", path.display())))?;
        let mut texture = texture::decode(&bytes).map_err(|what| wrong(format!("{}: {what}", path.display())))?;
        let rows: Vec<_> = texture.rgb.chunks(texture.width as usize).rev().collect();
        texture.rgb = rows.concat();
        let id = self.loader.add_texture(texture);
        self.texture_ids.insert(name.into(), id);
        Ok(id)
    }

    /// Adds triangles to `space`. The error says which limit they break.
    pub(super) fn add(&mut self, space: Space, material: MaterialId, faces: Vec<Face>) -> Result<(), String> {
        check_count(self.statics.len() + self.moving.len() + faces.len())?;
        let place = Transform::new(space.place);
        for Face { shape, uv } in faces {
            match shape {
                Shape::Rigid(pose) if space.node == ROOT => {
                    let world = pose.transformed(&place);
                    world.v.into_iter().try_for_each(|corner| check_reach(corner).map(|_| ()))?;
                    let (triangle, normals) = world.rounded();
                    self.statics.push(triangle, Attributes { normals, uv, material });
                }
                shape => {
                    let within = |pose: &Pose| pose.transformed(&place);
                    let shape = match shape {
                        Shape::Rigid(pose) => Shape::Rigid(within(&pose)),
                        Shape::Morph(keys) => {
                            Shape::Morph(keys.iter().map(|(time, pose)| (*time, within(pose))).collect())
                        }
                    };
                    self.moving.push(Moving { node: space.node, shape, uv, material });
                }
            }
        }
        Ok(())
    }

    /// Builds the scene. The error says what is missing or too far from the origin.
    pub(super) fn finish(self, name: String) -> Result<Scene, String> {
        let view = self.view.ok_or("no camera: the command `v` is needed")?;
        let motion = |name: &str| self.motions.get(name).cloned().unwrap_or_default();
        let still = |lamp: &Lamp| lamp.name.as_deref().map(motion).unwrap_or_default();
        // A light is a point: only the translation of its keyframes has an effect.
        let lamp_motion = |lamp: &Lamp| Motion { translation: still(lamp).translation, ..Motion::default() };
        let animation = AffAnimation {
            nodes: self.nodes.into_iter().map(|node| (node.clone(), motion(&node.name))).collect(),
            moving: self.moving,
            lamps: self.lamps.into_iter().map(|lamp| (lamp.clone(), lamp_motion(&lamp))).collect(),
            view,
            camera: motion("camera"),
            times: self.times,
        };
        let reach = animation.reach();
        if reach.is_nan() || reach > MAX_REACH {
            return Err(format!(
                "keyframes may move something to {reach:e} from the origin: at most {MAX_REACH:e} is allowed"
            ));
        }
        let (materials, textures, origin) = self.loader.finish();
        Ok(Scene {
            name,
            statics: self.statics,
            dynamic_count: animation.moving.len(),
            light_count: animation.lamps.len(),
            lamps: Lamps::points(),
            frame_count: animation.times.frames,
            materials,
            textures,
            background: self.background,
            ambient: self.ambient,
            origin,
            animation: Box::new(animation),
        })
    }
}
