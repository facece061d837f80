//! Scenes of Wavefront OBJ files: what stays comes from one file, lights, camera and moving objects from the config.

mod mtl;
mod read;

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Deserializer, Serialize, de::Error};

use self::mtl::Library;
use super::builtin::shapes::Shapes;
use super::lamps::rectangle;
use super::parts::{Part, Parts};
use super::path::{CameraSpec, CameraTrack, PoseKey, PoseTrack, pose_keys};
use super::render::MAX_LIGHTS;
use super::{Geometry, Lamps, Light, Material, MaterialId, Scene, SceneError, fields};
use crate::ranged::Within;

/// A scene of an OBJ file. Paths are relative to the folder of the config.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjSpec {
    /// The file of what stays.
    pub path: PathBuf,
    /// Lamps: points and rectangles, at most 64 points in all.
    #[serde(deserialize_with = "lights")]
    pub lights: Vec<LightSpec>,
    /// The camera.
    pub camera: CameraSpec,
    /// What moves.
    #[serde(default)]
    pub moving: Vec<MovingSpec>,
    /// How many frames there are.
    #[serde(default = "one_frame")]
    pub frame_count: Within<1, 1_000_000>,
    /// Colour of rays that hit nothing.
    #[serde(default, deserialize_with = "fields::color")]
    pub background: Vec3,
    /// Ambient light.
    #[serde(default = "dim", deserialize_with = "fields::color")]
    pub ambient: Vec3,
}

fn one_frame() -> Within<1, 1_000_000> {
    Within::new(1).expect("1 is within")
}

/// A tenth of full light: enough to see what lies in shadow.
fn dim() -> Vec3 {
    Vec3::splat(0.1)
}

fn lights<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<LightSpec>, D::Error> {
    let lights = Vec::<LightSpec>::deserialize(from)?;
    let flat = |area: &AreaSpec| area.u.cross(area.v).length() == 0.0;
    if lights.iter().any(|light| light.area.as_ref().is_some_and(flat)) {
        return Err(D::Error::custom("an area whose edges `u` and `v` are parallel is not allowed"));
    }
    let points: usize = lights.iter().map(LightSpec::points).sum();
    if points <= MAX_LIGHTS {
        Ok(lights)
    } else {
        Err(D::Error::custom(format!(
            "{} lights of {points} points: at most {MAX_LIGHTS} points are allowed",
            lights.len()
        )))
    }
}

/// A light: a point, or a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightSpec {
    /// Where it is, or its middle.
    #[serde(deserialize_with = "fields::point")]
    pub position: DVec3,
    /// Its colour and strength; white if left out.
    #[serde(default = "white", deserialize_with = "fields::color")]
    pub color: Vec3,
    /// What makes it a rectangle.
    #[serde(default)]
    pub area: Option<AreaSpec>,
}

/// A rectangular light (or any parallelogram), which casts soft shadows: every hit sends a shadow ray to each of its points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AreaSpec {
    /// Half of one edge.
    #[serde(deserialize_with = "fields::nonzero")]
    pub u: DVec3,
    /// Half of the other.
    #[serde(deserialize_with = "fields::nonzero")]
    pub v: DVec3,
    /// Points along each edge.
    pub points: Within<1, 8>,
}

impl LightSpec {
    fn points(&self) -> usize {
        self.area.map_or(1, |area| area.points.size().pow(2))
    }

    fn lights(&self) -> Vec<Light> {
        match self.area {
            None => vec![Light { position: self.position.as_vec3(), color: self.color }],
            Some(area) => rectangle(self.position, [area.u, area.v], area.points.size(), self.color).collect(),
        }
    }
}

fn white() -> Vec3 {
    Vec3::ONE
}

/// An object that moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MovingSpec {
    /// What it is.
    pub shape: ShapeSpec,
    /// Its colour. If left out, the colours of the OBJ file, or grey.
    #[serde(default, deserialize_with = "fields::optional_color")]
    pub color: Option<Vec3>,
    /// Where it is, at least at one frame.
    #[serde(deserialize_with = "pose_keys")]
    pub path: Vec<PoseKey>,
}

/// The shape of a moving object, around its origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ShapeSpec {
    /// The triangles of an OBJ file.
    Obj(PathBuf),
    /// A sphere around the origin.
    Sphere {
        /// Its radius.
        #[serde(deserialize_with = "fields::positive")]
        radius: f64,
        /// Its parts around the equator; half as many lie from pole to pole.
        #[serde(default = "round")]
        segments: Within<3, 1024>,
    },
    /// A box around the origin.
    Box {
        /// Its three sizes.
        #[serde(deserialize_with = "fields::size")]
        size: DVec3,
    },
}

fn round() -> Within<3, 1024> {
    Within::new(24).expect("24 is within")
}

/// The scene of `spec`, with paths relative to `base`.
///
/// # Errors
/// What cannot be read or is malformed (see the parts of this module), and cameras that look nowhere.
pub fn load(spec: &ObjSpec, base: &Path) -> Result<Scene, SceneError> {
    let path = base.join(&spec.path);
    let frame_count = spec.frame_count.get() as u32;
    let wrong = |what: String| SceneError::Content { path: path.clone(), what };
    let mut library = Library::default();
    let plain = library.add(Material { ambient: Material::default().diffuse, ..Material::default() });
    let statics = read::read(&path, plain, &mut library)?;
    let camera = CameraTrack::new(&spec.camera, frame_count).map_err(wrong)?;
    let mut parts = Vec::new();
    for moving in &spec.moving {
        let poses = PoseTrack::new(&moving.path).map_err(wrong)?;
        let geometry = shape(moving, base, plain, &mut library)?;
        parts.push(Part { geometry, pose: Box::new(move |frame| poses.at(frame)) });
    }
    let lights: Vec<_> = spec.lights.iter().flat_map(LightSpec::lights).collect();
    let light_count = lights.len();
    let parts = Parts { parts, lights, camera: Box::new(move |frame| camera.at(frame)) };
    Ok(Scene {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        statics,
        dynamic_count: parts.triangle_count(),
        light_count,
        lamps: Lamps::of_sizes(spec.lights.iter().map(LightSpec::points)),
        frame_count,
        materials: library.materials,
        textures: library.textures,
        background: spec.background,
        ambient: spec.ambient,
        animation: Box::new(parts),
    })
}

fn shape(moving: &MovingSpec, base: &Path, plain: MaterialId, library: &mut Library) -> Result<Geometry, SceneError> {
    let material = match moving.color {
        Some(color) => library.add(Material { ambient: color, diffuse: color, ..Material::default() }),
        None => plain,
    };
    let mut shapes = Shapes { material, ..Shapes::default() };
    match &moving.shape {
        ShapeSpec::Obj(path) => {
            let mut geometry = read::read(&base.join(path), material, library)?;
            if moving.color.is_some() {
                geometry.attributes.iter_mut().for_each(|attributes| attributes.material = material);
            }
            return Ok(geometry);
        }
        ShapeSpec::Sphere { radius, segments } => shapes.sphere(DVec3::ZERO, *radius, segments.size()),
        ShapeSpec::Box { size } => shapes.cuboid(*size * -0.5, *size * 0.5, size.max_element()),
    }
    Ok(shapes.geometry)
}

#[cfg(test)]
mod tests;
