//! Materials: metallic-roughness as far as a Whitted renderer shows it.
//!
//! Our own choice: metal mirrors as far as it is smooth. With metal m, roughness r and base colour c, the diffuse
//! colour is c (1 - m (1 - r)) and the specular one c m (1 - r). A blended surface lets 1 - alpha of the light through,
//! unbent.

use std::path::Path;

use glam::DVec3;
use gltf_json::Root;
use gltf_json::material::AlphaMode;
use gltf_json::validation::Checked;

use super::buffers::{self, Buffers};
use crate::scene::limits::SHARE;
use crate::scene::loader::Loader;
use crate::scene::material::{self, MaterialId, TextureId};
use crate::scene::texture;

/// A material of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Material {
    /// Its number in the scene.
    pub id: MaterialId,
    /// The set of texture coordinates of its picture.
    pub uv_set: u32,
    /// Whether it has a picture.
    pub textured: bool,
}

/// The materials of a file, each read when it is first used.
pub(super) struct Materials<'a> {
    root: &'a Root,
    buffers: &'a Buffers,
    path: &'a Path,
    plain: MaterialId,
    read: Vec<Option<Material>>,
    /// Textures by the number of the file's image.
    textures: Vec<Option<TextureId>>,
}

impl<'a> Materials<'a> {
    /// The materials of the file at `path`; a primitive without one gets `plain`.
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers, path: &'a Path, plain: MaterialId) -> Self {
        let (read, textures) = (vec![None; root.materials.len()], vec![None; root.images.len()]);
        Self { root, buffers, path, plain, read, textures }
    }

    /// Material number `index`; the plain material without a number.
    pub(super) fn get(&mut self, index: Option<usize>, loader: &mut Loader) -> Result<Material, String> {
        let Some(index) = index else { return Ok(Material { id: self.plain, uv_set: 0, textured: false }) };
        if let Some(Some(known)) = self.read.get(index) {
            return Ok(*known);
        }
        let found = self.root.materials.get(index).ok_or_else(|| format!("material {index} is not there"))?;
        let name = found.name.as_deref().unwrap_or_default();
        let read = self.add(found, loader).map_err(|what| format!("material {index} ({name:?}): {what}"))?;
        self.read[index] = Some(read);
        Ok(read)
    }

    fn add(&mut self, found: &gltf_json::Material, loader: &mut Loader) -> Result<Material, String> {
        let surface = &found.pbr_metallic_roughness;
        let [red, green, blue, alpha] = surface.base_color_factor.0.map(f64::from);
        let base = SHARE.check_color("`baseColorFactor`", DVec3::new(red, green, blue))?;
        let alpha = SHARE.check("the alpha of `baseColorFactor`", alpha)? as f32;
        let metal = SHARE.check("`metallicFactor`", surface.metallic_factor.0.into())? as f32;
        let rough = SHARE.check("`roughnessFactor`", surface.roughness_factor.0.into())? as f32;
        let mirror = metal * (1.0 - rough);
        for (there, what) in [
            (surface.metallic_roughness_texture.is_some(), "metallicRoughnessTexture"),
            (found.normal_texture.is_some(), "normalTexture"),
            (found.occlusion_texture.is_some(), "occlusionTexture"),
            (found.emissive_texture.is_some(), "emissiveTexture"),
            (found.emissive_factor.0 != [0.0; 3], "emissiveFactor"),
            (found.alpha_mode == Checked::Valid(AlphaMode::Mask), "alphaMode MASK"),
        ] {
            if there {
                loader.count_without_effect(self.path, what);
            }
        }
        let texture = match &surface.base_color_texture {
            Some(_) if loader.ignore_textures => {
                loader.count_without_effect(self.path, "baseColorTexture");
                None
            }
            Some(info) => Some((self.picture(info.index.value(), loader)?, info.tex_coord)),
            None => None,
        };
        let default = material::Material::default();
        let diffuse = base * (1.0 - mirror);
        let id = loader.add_material(material::Material {
            ambient: diffuse,
            diffuse,
            specular: base * mirror,
            transmittance: if found.alpha_mode == Checked::Valid(AlphaMode::Blend) { 1.0 - alpha } else { 0.0 },
            texture: texture.map(|(texture, _)| texture),
            ..default
        });
        Ok(Material { id, uv_set: texture.map_or(0, |(_, set)| set), textured: texture.is_some() })
    }

    fn picture(&mut self, texture: usize, loader: &mut Loader) -> Result<TextureId, String> {
        let index = self.root.textures.get(texture).map(|texture| texture.source.value());
        let image = index.and_then(|index| Some((index, self.root.images.get(index)?)));
        let Some((index, image)) = image else { return Err(missing(format!("texture {texture} has no image"))) };
        if let Some(known) = self.textures[index] {
            return Ok(known);
        }
        let id = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match buffers::data(uri) {
                Some(bytes) => loader.add_texture(decode(&bytes.map_err(missing)?)?),
                None => loader.picture(&buffers::beside(self.path, uri).map_err(missing)?).map_err(missing)?,
            },
            (None, Some(view)) => loader.add_texture(decode(self.buffers.view(self.root, view.value())?)?),
            (None, None) => return Err(missing(format!("image {index} has neither a URI nor a buffer view"))),
        };
        self.textures[index] = Some(id);
        Ok(id)
    }
}

fn decode(bytes: &[u8]) -> Result<material::Texture, String> {
    texture::decode(bytes).map_err(missing)
}

/// The error about a picture, with advice on loading the scene without pictures.
fn missing(what: String) -> String {
    format!("{what} (`textures: Ignore` in the scene's config takes the scene without its pictures)")
}
