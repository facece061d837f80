//! Scenes composed of files of triangles, and of the config's lights, camera and moving objects.

mod cameras;
mod files;
mod lights;
mod moving;
pub(crate) mod starter;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::cameras::CameraChoice;
use self::files::FileSpec;
use self::lights::LightSpec;
use self::moving::MovingSpec;
use super::error::SceneError;
use super::fields;
use super::frame::Scene;
use super::geometry::Geometry;
use super::lamps::Lamps;
use super::light::Light;
use super::limits;
use super::loader::Loader;
use super::material::Material;
use super::model::{FileCamera, FileLight, append};
use super::obj::Libraries;
use super::parts::{Part, Parts};
use crate::ranged::Within;

/// A scene made of files. Paths are relative to the folder of the config.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComposedSpec {
    /// The files of static objects, and of objects that glTF animations move. The first file gives the scene its name.
    #[serde(alias = "path", deserialize_with = "files::read")]
    #[schemars(extend("or_file" = true))]
    pub files: Vec<FileSpec>,
    /// Whether textures (pictures that colour surfaces) are used.
    #[serde(default)]
    pub textures: Wanted,
    /// Whether the files' own lights are used, in addition to `lights`.
    #[serde(default)]
    pub file_lights: Wanted,
    /// Point lights and rectangular lights, with at most 64 points in all.
    #[serde(default, deserialize_with = "lights::read")]
    pub lights: Vec<LightSpec>,
    /// The camera, or the name of a glTF file's camera.
    pub camera: CameraChoice,
    /// Further objects that move.
    #[serde(default)]
    pub moving: Vec<MovingSpec>,
    /// Number of frames.
    #[serde(default = "one_frame")]
    pub frame_count: Within<1, 1_000_000>,
    /// Frames per second of the files' animations.
    #[schemars(range(min = limits::LENGTH.low, max = limits::LENGTH.high))]
    #[serde(default = "frame_rate", deserialize_with = "fields::positive")]
    pub frame_rate: f64,
    /// Colour of rays that hit nothing.
    #[serde(default, deserialize_with = "fields::color")]
    #[schemars(with = "[f32; 3]")]
    pub background: Vec3,
    /// Ambient light.
    #[serde(default = "dim", deserialize_with = "fields::color")]
    #[schemars(with = "[f32; 3]")]
    pub ambient: Vec3,
}

/// Whether a part of the files' contents is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Wanted {
    /// It is used; if it is missing, that is an error.
    #[default]
    Use,
    /// It is ignored.
    Ignore,
}

fn one_frame() -> Within<1, 1_000_000> {
    const { Within::literal(1) }
}

fn frame_rate() -> f64 {
    30.0
}

/// A tenth of full light: enough to see what lies in shadow.
fn dim() -> Vec3 {
    Vec3::splat(0.1)
}

/// The contents of all files.
#[derive(Default)]
struct Contents {
    statics: Geometry,
    parts: Vec<Part>,
    cameras: Vec<FileCamera>,
    lights: Vec<FileLight>,
}

/// The scene of `spec`, with paths relative to `base`.
///
/// # Errors
/// A file that cannot be read or is malformed (see the readers of the formats), a camera without a direction, too many
/// lights, or something too far from the origin.
pub(crate) fn load(spec: &ComposedSpec, base: &Path) -> Result<Scene, SceneError> {
    let first = spec.files.first().map(|file| base.join(&file.path)).unwrap_or_default();
    let frame_count = spec.frame_count.get() as u32;
    let wrong = |what: String| SceneError::Content { path: first.clone(), what };
    let (mut loader, mut libraries) = (Loader::default(), Libraries::default());
    loader.ignore_textures = spec.textures == Wanted::Ignore;
    loader.ignore_lights = spec.file_lights == Wanted::Ignore;
    let plain = loader.add_material(Material { ambient: Material::default().diffuse, ..Material::default() });

    let mut contents = Contents::default();
    for file in &spec.files {
        let model = file.read(base, plain, file.place(), &mut loader, &mut libraries)?;
        append(&mut contents.statics, &model.statics, glam::DAffine3::IDENTITY).map_err(wrong)?;
        let rate = spec.frame_rate;
        contents.parts.extend(
            model
                .moving
                .into_iter()
                .map(|(geometry, pose)| Part { geometry, pose: Box::new(move |frame| pose(f64::from(frame) / rate)) }),
        );
        contents.cameras.extend(model.cameras);
        contents.lights.extend(model.lights);
    }
    for moving in &spec.moving {
        contents.parts.push(moving.part(base, plain, frame_count, &mut loader, &mut libraries, &wrong)?);
    }
    let camera = spec.camera.track(contents.cameras, frame_count, spec.frame_rate).map_err(wrong)?;

    // Lights that stand still come first, the config's before the files'.
    let (carried, still): (Vec<_>, Vec<_>) = contents.lights.into_iter().partition(|light| light.moves);
    let own: Vec<_> = spec.lights.iter().flat_map(LightSpec::lights).collect();
    let light_count = own.len() + still.len() + carried.len();
    lights::check_count(light_count).map_err(wrong)?;
    let sizes = spec.lights.iter().map(LightSpec::points).chain(std::iter::repeat_n(1, still.len() + carried.len()));
    let lamps = Lamps::of_sizes(sizes);
    let rate = spec.frame_rate;
    let parts = Parts {
        parts: contents.parts,
        lights: own.into_iter().chain(still.iter().map(|light| light_at(light, 0.0))).collect(),
        carried: carried
            .into_iter()
            .map(|light| Box::new(move |frame: u32| light_at(&light, f64::from(frame) / rate)) as _)
            .collect(),
        camera,
    };
    let (materials, textures, origin) = loader.finish();
    Ok(Scene {
        name: first.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        statics: contents.statics,
        dynamic_count: parts.triangle_count(),
        light_count,
        lamps,
        frame_count,
        materials,
        textures,
        background: spec.background,
        ambient: spec.ambient,
        origin,
        animation: Box::new(parts),
    })
}

fn light_at(light: &FileLight, time: f64) -> Light {
    Light { position: (light.pose)(time).translation.as_vec3(), color: light.color }
}
