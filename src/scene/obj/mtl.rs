//! Material libraries (MTL), and the pictures that they name.
//!
//! Source: Wavefront Technologies, "MTL material format (Lightwave, OBJ)", version 4.2; its sections are named beside
//! the statements. `Tr`, `Ke` and the statements of "Physically based rendering extension to the MTL format" are later
//! additions of exporters. Statements are case-insensitive, since exporters write them in different cases.
//!
//! `Kd` colours the surface in point light and in ambient light, `Ks`, `Ns` and `Ni` are as in the specification, and
//! the transmittance is 1 - `d`, or `Tr`.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::map;
use super::names::{Entry, Materials, beside};
use crate::scene::error::SceneError;
use crate::scene::limits::{REFRACTION, Range, SHARE, SHININESS, STRENGTH};
use crate::scene::loader::Loader;
use crate::scene::material::Material;
use crate::scene::text::{Line, each_line, number, shortened, without_comment, words};

/// Statements that are known and have no effect here, in lower case.
const WITHOUT_EFFECT: &[&str] = &[
    // Material color and illumination: ambient light takes `Kd`, there is one way of illumination and no filter.
    "ka",
    "tf",
    "illum",
    "sharpness",
    // Material texture map, but for `map_Kd`.
    "map_ka",
    "map_ks",
    "map_ns",
    "map_d",
    "map_aat",
    "decal",
    "disp",
    "bump",
    // Material reflection map.
    "refl",
    // Additions of exporters: light that a surface sends out, and spellings of the maps above.
    "ke",
    "map_ke",
    "map_bump",
    "map_disp",
    "map_refl",
    "map_tr",
    "map_tf",
    "map_ni",
    "map_opacity",
    // Physically based rendering extension.
    "pr",
    "map_pr",
    "pm",
    "map_pm",
    "ps",
    "map_ps",
    "pc",
    "pcr",
    "aniso",
    "anisor",
    "norm",
    "map_rma",
    "map_orm",
];

/// The materials of the library at `path`, added to `loader`.
///
/// # Errors
/// An unknown statement, a statement before the first `newmtl`, a name that is missing or defined twice, numbers that
/// are malformed or out of range, a picture that cannot be read; each with its line.
pub(super) fn parse(path: &Path, bytes: &[u8], loader: &mut Loader) -> Result<Materials, SceneError> {
    let mut library = Library { materials: Materials::default(), open: None };
    each_line(bytes, |line| library.read(line, path, loader)).map_err(|(line, what)| SceneError::Syntax {
        path: path.to_owned(),
        line,
        what,
    })?;
    library.close(path, loader);
    Ok(library.materials)
}

struct Library {
    materials: Materials,
    /// The material that the next statements describe.
    open: Option<Open>,
}

struct Open {
    name: String,
    material: Material,
    map: map::UvMap,
    /// Opacity `d` and transparency `Tr`, if given.
    opacity: Option<f32>,
    transparency: Option<f32>,
}

impl Library {
    fn read(&mut self, line: &Line<'_>, path: &Path, loader: &mut Loader) -> Result<(), String> {
        let statement = line.word.to_ascii_lowercase();
        if statement == "newmtl" {
            self.close(path, loader);
            return self.open(line.rest);
        }
        let known = READ.contains(&statement.as_str()) || WITHOUT_EFFECT.contains(&statement.as_str());
        if !known {
            return Err(format!(
                "`{}` is no statement of a material library: newmtl, {} are read, and these have no effect: {}",
                shortened(line.word).escape_debug(),
                "Kd, Ks, Ns, Ni, d, Tr and map_Kd",
                WITHOUT_EFFECT.join(" ")
            ));
        }
        let Some(open) = &mut self.open else {
            return Err(format!("`{}` stands before the first `newmtl`: it belongs to no material", line.word));
        };
        match statement.as_str() {
            "kd" => {
                open.material.diffuse = color(line, SHARE)?;
                open.material.ambient = open.material.diffuse;
            }
            "ks" => open.material.specular = color(line, SHARE)?,
            "ns" => open.material.shininess = single(line, SHININESS)?,
            "ni" => open.material.index_of_refraction = single(line, REFRACTION)?,
            "d" => open.opacity = Some(single(line, SHARE)?),
            "tr" => open.transparency = Some(single(line, SHARE)?),
            "map_kd" => {
                let (map, name) = map::options(line.rest)?;
                if loader.ignore_textures {
                    loader.count_without_effect(path, line.word);
                } else {
                    open.map = map;
                    open.material.texture = Some(picture(path, name, loader)?);
                }
            }
            _ => {
                check_ignored(&statement, line)?;
                loader.count_without_effect(path, line.word);
            }
        }
        Ok(())
    }

    fn open(&mut self, name: &str) -> Result<(), String> {
        if name.is_empty() || name.starts_with('#') {
            return Err("`newmtl` needs a name".into());
        }
        if self.materials.contains(name) {
            return Err(format!("a material {:?} is defined already: each name once is allowed", shortened(name)));
        }
        let (material, map) = Default::default();
        self.open = Some(Open { name: name.to_owned(), material, map, opacity: None, transparency: None });
        Ok(())
    }

    /// Adds the material whose statements have ended.
    fn close(&mut self, path: &Path, loader: &mut Loader) {
        let Some(mut open) = self.open.take() else { return };
        let from_opacity = open.opacity.map(|opacity| 1.0 - opacity);
        if let (Some(one), Some(other)) = (from_opacity, open.transparency)
            && (one - other).abs() > 1e-3
        {
            let name = &open.name;
            loader.notice(path, &format!("material {name:?} has a `d` and another `Tr`, which is 1 - d: `d` counts"));
        }
        if let Some(transmittance) = from_opacity.or(open.transparency) {
            open.material.transmittance = transmittance;
        }
        let id = loader.add_material(open.material);
        self.materials.insert(&open.name, Entry { id, map: open.map });
    }
}

/// Statements that are read, in lower case, beside `newmtl`.
const READ: &[&str] = &["kd", "ks", "ns", "ni", "d", "tr", "map_kd"];

/// Colours without effect must be valid nevertheless: a library that is broken there is broken elsewhere.
fn check_ignored(statement: &str, line: &Line<'_>) -> Result<(), String> {
    match statement {
        "ka" => color(line, SHARE).map(|_| ()),
        "ke" => color(line, STRENGTH).map(|_| ()),
        _ => Ok(()),
    }
}

/// Three numbers, or one for all three (section "Material color and illumination").
fn color(line: &Line<'_>, range: Range) -> Result<Vec3, String> {
    let numbers: Vec<f32> = words(line.rest).map(number).collect::<Result<_, _>>()?;
    let color = match numbers[..] {
        [grey] => Vec3::splat(grey),
        [red, green, blue] => Vec3::new(red, green, blue),
        _ => return Err(format!("`{}` of {} numbers: red, green and blue are needed", line.word, numbers.len())),
    };
    range.check_color(&format!("`{}`", line.word), DVec3::from(color))
}

fn single(line: &Line<'_>, range: Range) -> Result<f32, String> {
    let numbers: Vec<f32> = words(line.rest).map(number).collect::<Result<_, _>>()?;
    let [value] = numbers[..] else {
        return Err(format!("`{}` of {} numbers: one is needed", line.word, numbers.len()));
    };
    range.check(&format!("`{}`", line.word), value.into()).map(|_| value)
}

fn picture(library: &Path, name: &str, loader: &mut Loader) -> Result<crate::scene::TextureId, String> {
    let before_comment = without_comment(name);
    let found = [name, before_comment].into_iter().find(|name| beside(library, name).exists());
    let name = found.unwrap_or(before_comment);
    loader.picture(&beside(library, name)).map_err(|what| format!("map_Kd {:?}: {what}", shortened(name)))
}
