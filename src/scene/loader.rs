//! State that the readers of a scene's files share: the files, materials, pictures, and notices for the user.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::frame::Origin;
use super::material::{Material, MaterialId, Texture, TextureId};
use super::polygon::Cutter;
use super::texture;
use crate::input::Files;

/// The state of reading one scene.
#[derive(Default)]
pub(super) struct Loader {
    /// The files, each read once.
    pub files: Files,
    /// All materials.
    pub materials: Vec<Material>,
    /// All textures.
    pub textures: Vec<Texture>,
    /// Whether pictures are left out; a scene is then drawn in its materials' own colours.
    pub ignore_textures: bool,
    /// Whether lights of files are left out.
    pub ignore_lights: bool,
    /// Cuts polygons.
    pub cutter: Cutter,
    /// Pictures by canonical path.
    pictures: BTreeMap<PathBuf, TextureId>,
    /// For each file, the number of statements without effect of each kind.
    without_effect: BTreeMap<PathBuf, BTreeMap<String, usize>>,
    notices: Vec<String>,
}

impl Loader {
    /// Adds a material.
    pub(super) fn add_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        MaterialId((self.materials.len() - 1) as u32)
    }

    /// Adds a texture.
    pub(super) fn add_texture(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture);
        TextureId((self.textures.len() - 1) as u32)
    }

    /// The texture in the picture file at `path`; each file is decoded once. The error is a sentence that names the
    /// file.
    pub(super) fn picture(&mut self, path: &Path) -> Result<TextureId, String> {
        let bytes = self.files.read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let real = path.canonicalize().unwrap_or_else(|_| path.into());
        if let Some(id) = self.pictures.get(&real) {
            return Ok(*id);
        }
        let texture = texture::decode(&bytes).map_err(|what| format!("{}: {what}", path.display()))?;
        let id = self.add_texture(texture);
        self.pictures.insert(real, id);
        Ok(id)
    }

    /// Counts a statement of the file at `path` that has no effect here.
    pub(super) fn count_without_effect(&mut self, path: &Path, statement: &str) {
        if let Some(count) = self.without_effect.get_mut(path).and_then(|counts| counts.get_mut(statement)) {
            *count += 1;
        } else {
            self.without_effect.entry(path.into()).or_default().insert(statement.into(), 1);
        }
    }

    /// Adds a notice about a file for the user.
    pub(super) fn notice(&mut self, path: &Path, what: &str) {
        self.notices.push(format!("{}: {what}", name(path)));
    }

    /// The materials, textures and origin of the scene.
    pub(super) fn finish(self) -> (Vec<Material>, Vec<Texture>, Origin) {
        let mut notices: Vec<_> = self.without_effect.iter().map(|(path, counts)| counted(path, counts)).collect();
        notices.extend(self.notices);
        (self.materials, self.textures, Origin { sources: self.files.into_sources(), notices })
    }
}

fn counted(path: &Path, counts: &BTreeMap<String, usize>) -> String {
    let (kinds, verb) = if counts.len() == 1 { ("kind", "has") } else { ("kinds", "have") };
    let list: Vec<_> = counts.iter().map(|(statement, count)| format!("`{statement}` ({count})")).collect();
    format!("{}: {} {kinds} of statements {verb} no effect: {}", name(path), counts.len(), list.join(", "))
}

/// A file's name without its folder, so that a report does not depend on the folder.
fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_without_effect_are_told_once() {
        let mut loader = Loader::default();
        for statement in ["g", "s", "g"] {
            loader.count_without_effect(Path::new("a.obj"), statement);
        }
        loader.notice(Path::new("b.obj"), "it is empty.");
        let (.., origin) = loader.finish();
        assert_eq!(
            origin.notices,
            ["a.obj: 2 kinds of statements have no effect: `g` (2), `s` (1)", "b.obj: it is empty."]
        );
    }
}
