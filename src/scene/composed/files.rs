//! Files of triangles, each with a place in the scene.

use std::fmt;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::scene::error::SceneError;
use crate::scene::fields;
use crate::scene::limits;
use crate::scene::loader::Loader;
use crate::scene::material::MaterialId;
use crate::scene::model::Model;
use crate::scene::obj::{self, Libraries};
use crate::scene::{gltf, ply};

/// A file and the placement of its contents: they are scaled first, then rotated, then translated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileSpec {
    /// The file: OBJ (`.obj`), PLY (`.ply`) or glTF 2.0 (`.gltf`, `.glb`).
    pub path: PathBuf,
    /// Scale factor.
    #[schemars(range(min = limits::LENGTH.low, max = limits::LENGTH.high))]
    #[serde(default = "unscaled", deserialize_with = "fields::positive")]
    pub scale: f64,
    /// Rotation about x, then y, then z, in degrees.
    #[serde(default, deserialize_with = "fields::vector")]
    #[schemars(with = "[f64; 3]")]
    pub rotate: DVec3,
    /// Translation, in units of the scene.
    #[serde(default, deserialize_with = "fields::vector")]
    #[schemars(with = "[f64; 3]")]
    pub translate: DVec3,
    /// Name of the glTF animation that moves the file's nodes. May be left out if the file has at most one.
    #[serde(default)]
    pub animation: Option<String>,
}

fn unscaled() -> f64 {
    1.0
}

impl FileSpec {
    /// A file that is neither scaled, turned nor moved.
    pub(super) fn of(path: PathBuf) -> Self {
        Self { path, scale: 1.0, rotate: DVec3::ZERO, translate: DVec3::ZERO, animation: None }
    }

    /// From the file's space to the world.
    pub(super) fn place(&self) -> DAffine3 {
        let [x, y, z] = self.rotate.to_array().map(f64::to_radians);
        let turned = DQuat::from_euler(EulerRot::ZYX, z, y, x);
        DAffine3::from_scale_rotation_translation(DVec3::splat(self.scale), turned, self.translate)
    }

    /// The contents of the file, at `place`. Triangles without a material get `plain`.
    pub(super) fn read(
        &self,
        base: &Path,
        plain: MaterialId,
        place: DAffine3,
        loader: &mut Loader,
        libraries: &mut Libraries,
    ) -> Result<Model, SceneError> {
        let path = base.join(&self.path);
        let kind = path.extension().map(|kind| kind.to_string_lossy().to_ascii_lowercase());
        if let Some(animation) = &self.animation
            && !matches!(kind.as_deref(), Some("gltf" | "glb"))
        {
            let what = format!("`animation` is {animation:?}: only a glTF file has one");
            return Err(SceneError::Content { path, what });
        }
        match kind.as_deref() {
            Some("obj") => {
                obj::read(&path, plain, loader, libraries).and_then(|geometry| Model::still(geometry, place, &path))
            }
            Some("ply") => ply::read(&path, plain, loader).and_then(|geometry| Model::still(geometry, place, &path)),
            Some("gltf" | "glb") => gltf::read(&path, self.animation.as_deref(), plain, place, loader),
            _ => {
                let what = "its name must end in .obj, .ply, .gltf or .glb: that tells its format".into();
                Err(SceneError::Content { path, what })
            }
        }
    }
}

/// Reads files: one, or a list; each by its name or with its place.
pub(super) fn read<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<FileSpec>, D::Error> {
    struct Files;

    impl<'de> Visitor<'de> for Files {
        type Value = Vec<FileSpec>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("the name of a file, a file with its place in brackets, or a list of such")
        }

        fn visit_str<E: Error>(self, path: &str) -> Result<Self::Value, E> {
            Ok(vec![FileSpec::of(path.into())])
        }

        fn visit_map<A: MapAccess<'de>>(self, values: A) -> Result<Self::Value, A::Error> {
            FileSpec::deserialize(MapAccessDeserializer::new(values)).map(|file| vec![file])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
            let mut files = Vec::new();
            while let Some(NamedOrPlaced(file)) = list.next_element()? {
                files.push(file);
            }
            if files.is_empty() {
                Err(A::Error::custom("an empty list of files: at least one is needed"))
            } else {
                Ok(files)
            }
        }
    }

    from.deserialize_any(Files)
}

/// A file by its name alone, or with its place.
struct NamedOrPlaced(FileSpec);

impl<'de> Deserialize<'de> for NamedOrPlaced {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct File;

        impl<'de> Visitor<'de> for File {
            type Value = NamedOrPlaced;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a file, or a file with its place in brackets")
            }

            fn visit_str<E: Error>(self, path: &str) -> Result<Self::Value, E> {
                Ok(NamedOrPlaced(FileSpec::of(path.into())))
            }

            fn visit_map<A: MapAccess<'de>>(self, values: A) -> Result<Self::Value, A::Error> {
                FileSpec::deserialize(MapAccessDeserializer::new(values)).map(NamedOrPlaced)
            }
        }

        from.deserialize_any(File)
    }
}
