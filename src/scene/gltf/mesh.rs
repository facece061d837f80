//! Meshes: the triangles of their primitives.

use std::path::Path;

use glam::{DVec3, Vec2};
use gltf_json::Root;
use gltf_json::accessor::ComponentType;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;

use super::accessor::Elements;
use super::buffers::Buffers;
use super::materials::{Material, Materials};
use crate::scene::geometry::{Attributes, Geometry, Triangle};
use crate::scene::limits::{self, COORDINATE};
use crate::scene::loader::Loader;
use crate::scene::material::MaterialId;

/// The meshes of a file, each read when it is first placed.
pub(super) struct Meshes<'a> {
    root: &'a Root,
    buffers: &'a Buffers,
    path: &'a Path,
    materials: Materials<'a>,
    read: Vec<Option<Geometry>>,
}

impl<'a> Meshes<'a> {
    /// The meshes of the file at `path`.
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers, path: &'a Path, plain: MaterialId) -> Self {
        let read = root.meshes.iter().map(|_| None).collect();
        Self { root, buffers, path, materials: Materials::new(root, buffers, path, plain), read }
    }

    /// The triangles of a mesh in its own space.
    pub(super) fn get(&mut self, index: usize, loader: &mut Loader) -> Result<&Geometry, String> {
        if self.read.get(index).is_none_or(Option::is_none) {
            let mesh = self.root.meshes.get(index).ok_or_else(|| format!("mesh {index} is not there"))?;
            let mut geometry = Geometry::default();
            for primitive in &mesh.primitives {
                self.add(primitive, &mut geometry, loader).map_err(|what| {
                    let name = mesh.name.as_deref().map(|name| format!(" ({name:?})")).unwrap_or_default();
                    format!("mesh {index}{name}: {what}")
                })?;
            }
            self.read[index] = Some(geometry);
        }
        self.read[index].as_ref().ok_or_else(|| format!("mesh {index} is not there"))
    }

    fn add(&mut self, primitive: &Primitive, geometry: &mut Geometry, loader: &mut Loader) -> Result<(), String> {
        if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
            return Err("it has morph targets: they are not read".into());
        }
        let Checked::Valid(mode) = primitive.mode else {
            return Err("a primitive is of no mode of the specification".into());
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            // Rays cannot hit points and lines.
            loader.count_without_effect(self.path, "primitives of points or lines");
            return Ok(());
        }
        let material = self.materials.get(primitive.material.map(|material| material.value()), loader)?;
        let vertices = Vertices::new(self.root, self.buffers, primitive, &material)?;
        let indices =
            primitive.indices.map(|index| Elements::<1>::new(self.root, self.buffers, index.value(), "indices"));
        let indices = indices.transpose()?;
        if let Some(indices) = &indices
            && !matches!(indices.component(), (ComponentType::U8 | ComponentType::U16 | ComponentType::U32, false))
        {
            return Err("its indices are not of unsigned integers".into());
        }
        let count = indices.as_ref().map_or(vertices.positions.len(), Elements::len);
        let corner = |at: usize| match &indices {
            Some(indices) => indices.get(at).map_or(at, |[index]| index as usize),
            None => at,
        };
        let triangles = match mode {
            Mode::Triangles if count % 3 != 0 => return Err(format!("{count} corners make no whole triangles")),
            Mode::Triangles => count / 3,
            _ => count.saturating_sub(2),
        };
        limits::check_count(geometry.len() + triangles)?;
        for at in 0..triangles {
            let places = match mode {
                Mode::Triangles => [3 * at, 3 * at + 1, 3 * at + 2],
                // Every second triangle of a strip turns the other way in the file.
                Mode::TriangleStrip => [at, at + 1 + at % 2, at + 2 - at % 2],
                _ => [0, at + 1, at + 2],
            };
            let (triangle, attributes) = vertices.triangle(places.map(corner), &material)?;
            geometry.push(triangle, attributes);
        }
        Ok(())
    }
}

/// The vertex data of a primitive.
struct Vertices<'a> {
    positions: Elements<'a, 3>,
    normals: Option<Elements<'a, 3>>,
    uvs: Option<Elements<'a, 2>>,
}

impl<'a> Vertices<'a> {
    fn new(root: &Root, buffers: &'a Buffers, primitive: &Primitive, material: &Material) -> Result<Self, String> {
        let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
        let positions = find(Semantic::Positions).ok_or("a primitive has no positions")?;
        let positions = Elements::<3>::new(root, buffers, positions, "positions")?;
        let normals = find(Semantic::Normals).map(|index| Elements::<3>::new(root, buffers, index, "normals"));
        let normals = normals.transpose()?;
        let floats = |elements: &Elements<'_, 3>| elements.component() == (ComponentType::F32, false);
        if !floats(&positions) || normals.as_ref().is_some_and(|normals| !floats(normals)) {
            return Err("its positions or normals are not of floats".into());
        }
        let uvs = find(Semantic::TexCoords(material.uv_set));
        let uvs = uvs.map(|index| Elements::<2>::new(root, buffers, index, "texture coordinates")).transpose()?;
        let known = |elements: &Elements<'_, 2>| {
            let (component, normalized) = elements.component();
            match component {
                ComponentType::F32 => true,
                ComponentType::U8 | ComponentType::U16 => normalized,
                _ => false,
            }
        };
        if uvs.as_ref().is_some_and(|uvs| !known(uvs)) {
            return Err("its texture coordinates are neither floats nor normalized".into());
        }
        if material.textured && uvs.is_none() {
            return Err(format!("its material has a picture, and it has no TEXCOORD_{}", material.uv_set));
        }
        Ok(Self { positions, normals, uvs })
    }

    fn triangle(&self, corners: [usize; 3], material: &Material) -> Result<(Triangle, Attributes), String> {
        let outside =
            |kind: &str, index: usize, count: usize| format!("{kind} {index} is asked for, and there are {count}");
        let vectors = |elements: &Elements<'_, 3>, kind: &str| -> Result<[DVec3; 3], String> {
            let mut found = [DVec3::ZERO; 3];
            for (place, index) in found.iter_mut().zip(corners) {
                let value = elements.get(index).ok_or_else(|| outside(kind, index, elements.len()))?;
                *place = COORDINATE.check_vector(kind, DVec3::from_array(value))?;
            }
            Ok(found)
        };
        let v = vectors(&self.positions, "a position")?.map(|corner| corner.as_vec3());
        let normals = self.normals.as_ref().map(|normals| vectors(normals, "a normal")).transpose()?;
        let normals = normals.map(|normals| normals.map(DVec3::normalize_or_zero));
        // A normal of length zero has no direction: the triangle shades flat.
        let normals = normals.filter(|normals| !normals.contains(&DVec3::ZERO));
        let mut uv = [Vec2::ZERO; 3];
        if let Some(uvs) = &self.uvs {
            for (place, index) in uv.iter_mut().zip(corners) {
                let [u, v] = uvs.get(index).ok_or_else(|| outside("texture coordinate", index, uvs.len()))?;
                COORDINATE.check_vector("a texture coordinate", DVec3::new(u, v, 0.0))?;
                // glTF has v = 0 at the first row, textures here have v = 1 there.
                *place = Vec2::new(u as f32, (1.0 - v) as f32);
            }
        }
        let normals = normals.map(|normals| normals.map(|normal| normal.as_vec3()));
        Ok((Triangle { v }, Attributes { normals, uv, material: material.id }))
    }
}
