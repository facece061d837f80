//! Reads material libraries (MTL) with tobj, and the pictures that they name.
//!
//! tobj panics at a colour of fewer than three numbers, and gives no lines: numbers are checked here first.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::Vec3;

use super::read::numbers;
use crate::input;
use crate::scene::{Material, MaterialId, SceneError, Texture, TextureId, texture};

/// The materials of one OBJ file by name.
pub type Names = BTreeMap<String, MaterialId>;

/// The materials and textures of a scene.
#[derive(Debug, Default)]
pub struct Library {
    /// All materials.
    pub materials: Vec<Material>,
    /// All textures.
    pub textures: Vec<Texture>,
}

impl Library {
    /// Adds a material.
    pub fn add(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId((self.materials.len() - 1) as u32)
    }

    /// Adds the materials of the file at `path` and their names.
    ///
    /// `Kd` colours the surface in point light and in ambient light, `Ks`, `Ns` and `Ni` are as in the MTL format, and
    /// 1 - `d` is the transmittance.
    ///
    /// # Errors
    /// A file that is missing, numbers that are malformed or out of range, a picture that cannot be had.
    pub fn read(&mut self, path: &Path, names: &mut Names) -> Result<(), SceneError> {
        let bytes = input::read(path, input::MAX_SCENE_FILE_BYTES)
            .map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
        self.parse(path, &bytes, names)
    }

    /// As [`Self::read`], of the file's bytes.
    pub(super) fn parse(&mut self, path: &Path, bytes: &[u8], names: &mut Names) -> Result<(), SceneError> {
        let text = String::from_utf8_lossy(bytes);
        for (index, line) in text.lines().enumerate() {
            check(line.trim()).map_err(|what| SceneError::Syntax { path: path.to_owned(), line: index + 1, what })?;
        }
        let wrong = |what: String| SceneError::Content { path: path.to_owned(), what };
        let (materials, _) = tobj::load_mtl_buf(&mut text.as_bytes()).map_err(|error| wrong(error.to_string()))?;
        for found in materials {
            let base = Material::default();
            let diffuse = found.diffuse.map_or(base.diffuse, Vec3::from_array);
            let texture = match &found.diffuse_texture {
                Some(name) => Some(self.picture(path, name)?),
                None => None,
            };
            let id = self.add(Material {
                ambient: diffuse,
                diffuse,
                specular: found.specular.map_or(base.specular, Vec3::from_array),
                shininess: found.shininess.unwrap_or(base.shininess),
                transmittance: found.dissolve.map_or(base.transmittance, |opaque| 1.0 - opaque),
                index_of_refraction: found.optical_density.unwrap_or(base.index_of_refraction),
                texture,
            });
            names.insert(found.name, id);
        }
        Ok(())
    }

    fn picture(&mut self, library: &Path, name: &str) -> Result<TextureId, SceneError> {
        let wrong = |what: String| SceneError::Content { path: library.to_owned(), what };
        let path = library.parent().map_or_else(|| name.into(), |folder| folder.join(name));
        let kind = path.extension().map(|kind| kind.to_ascii_lowercase());
        let texture = match kind.as_ref().and_then(|kind| kind.to_str()) {
            Some("png") => png(&path),
            Some("ppm") => texture::read_ppm(&path),
            _ => return Err(wrong(format!("map_Kd {name:?} is not allowed: the name of a .png or .ppm file is"))),
        };
        let texture = texture.map_err(|error| match error {
            // Who names the picture is the news; that it is not there is only half of it.
            SceneError::Read { path, source } => {
                wrong(format!("map_Kd {name:?}: cannot read {}: {source}", path.display()))
            }
            other => other,
        })?;
        self.textures.push(texture);
        Ok(TextureId((self.textures.len() - 1) as u32))
    }
}

/// Checks the numbers of a line of an MTL file.
fn check(line: &str) -> Result<(), String> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let (least, range) = match word {
        "Ka" | "Kd" | "Ks" => (3, 0.0..=1.0),
        "Ke" => (3, 0.0..=f32::MAX),
        "d" => (1, 0.0..=1.0),
        "Ns" | "Ni" => (1, 0.0..=f32::MAX),
        _ => return Ok(()),
    };
    match numbers(rest, least)?.iter().find(|number| !range.contains(number)) {
        Some(number) => {
            Err(format!("{word} of {number} is not allowed: numbers from {} to {} are", range.start(), range.end()))
        }
        None => Ok(()),
    }
}

/// Reads a PNG file of any colour type; transparency is dropped.
fn png(path: &Path) -> Result<Texture, SceneError> {
    let wrong = |error: png::DecodingError| SceneError::Content { path: path.to_owned(), what: error.to_string() };
    let file = File::open(path).map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    let mut decoder = png::Decoder::new(BufReader::new(file));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(wrong)?;
    let too_large = || SceneError::Content { path: path.to_owned(), what: "the picture does not fit in memory".into() };
    let mut bytes = vec![0; reader.output_buffer_size().ok_or_else(too_large)?];
    let info = reader.next_frame(&mut bytes).map_err(wrong)?;
    let samples = info.color_type.samples();
    let rgb = bytes[..info.buffer_size()].chunks_exact(samples);
    // One or two samples are grey (and alpha), three or four are colour (and alpha).
    let rgb = rgb.map(|pixel| if samples < 3 { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] }).collect();
    Ok(Texture { width: info.width, height: info.height, rgb })
}
