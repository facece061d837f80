//! Objects that a config moves.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::files::FileSpec;
use crate::ranged::Within;
use crate::scene::builtin::shapes::Shapes;
use crate::scene::error::SceneError;
use crate::scene::fields;
use crate::scene::geometry::Geometry;
use crate::scene::limits::{LENGTH, MAX_REACH};
use crate::scene::loader::Loader;
use crate::scene::material::{Material, MaterialId};
use crate::scene::obj::Libraries;
use crate::scene::parts::Part;
use crate::scene::path::{PoseKey, PoseTrack, pose_keys};

/// A moving object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MovingSpec {
    /// The shape of the object.
    pub shape: ShapeSpec,
    /// The colour of the object. If left out: the colours of its file, or grey.
    #[serde(default, deserialize_with = "fields::optional_surface")]
    #[schemars(with = "Option<[f32; 3]>")]
    pub color: Option<Vec3>,
    /// Key frames of the object's path, at least one.
    #[serde(deserialize_with = "pose_keys")]
    pub path: Vec<PoseKey>,
}

/// The shape of a moving object, around its origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum ShapeSpec {
    /// The triangles of a file: OBJ, PLY or glTF without an animation.
    #[serde(alias = "Obj")]
    File(PathBuf),
    /// A sphere around the origin.
    Sphere {
        /// Radius of the sphere.
        #[schemars(range(min = LENGTH.low, max = LENGTH.high))]
        #[serde(deserialize_with = "fields::positive")]
        radius: f64,
        /// Number of segments around the equator; half this number from pole to pole.
        #[serde(default = "round")]
        segments: Within<3, 1024>,
    },
    /// A box around the origin.
    Box {
        /// Edge lengths along x, y and z.
        #[serde(deserialize_with = "fields::size")]
        #[schemars(with = "[f64; 3]")]
        size: DVec3,
    },
}

fn round() -> Within<3, 1024> {
    Within::new(24).expect("24 is within")
}

impl MovingSpec {
    /// The object with its path over `frame_count` frames. `wrong` makes an error of the scene as a whole.
    pub(super) fn part(
        &self,
        base: &Path,
        plain: MaterialId,
        frame_count: u32,
        loader: &mut Loader,
        libraries: &mut Libraries,
        wrong: &dyn Fn(String) -> SceneError,
    ) -> Result<Part, SceneError> {
        let track = PoseTrack::new(&self.path).map_err(wrong)?;
        let material = match self.color {
            Some(color) => loader.add_material(Material { ambient: color, diffuse: color, ..Material::default() }),
            None => plain,
        };
        let mut geometry = match &self.shape {
            ShapeSpec::File(path) => still(path, base, material, loader, libraries)?,
            ShapeSpec::Sphere { radius, segments } => {
                shape(material, |shapes| shapes.sphere(DVec3::ZERO, *radius, segments.size()))
            }
            ShapeSpec::Box { size } => {
                shape(material, |shapes| shapes.cuboid(*size * -0.5, *size * 0.5, size.max_element()))
            }
        };
        if self.color.is_some() {
            geometry.attributes.iter_mut().for_each(|attributes| attributes.material = material);
        }
        check_path(&track, &geometry, frame_count).map_err(wrong)?;
        Ok(Part { geometry, pose: Box::new(move |frame| track.at(frame)) })
    }
}

fn shape(material: MaterialId, make: impl FnOnce(&mut Shapes)) -> Geometry {
    let mut shapes = Shapes { material, ..Shapes::default() };
    make(&mut shapes);
    shapes.geometry
}

/// The triangles of a file in which nothing moves.
fn still(
    path: &Path,
    base: &Path,
    material: MaterialId,
    loader: &mut Loader,
    libraries: &mut Libraries,
) -> Result<Geometry, SceneError> {
    let file = FileSpec::of(path.into());
    let model = file.read(base, material, DAffine3::IDENTITY, loader, libraries)?;
    if model.moving.is_empty() {
        Ok(model.statics)
    } else {
        let what = "a file with an animation cannot be the shape of a moving object".into();
        Err(SceneError::Content { path: base.join(path), what })
    }
}

/// Refuses a path that leads too far, or on which the scale becomes too small: curves can overshoot their keys.
fn check_path(track: &PoseTrack, geometry: &Geometry, frame_count: u32) -> Result<(), String> {
    let corners = geometry.triangles.iter().flat_map(|triangle| triangle.v);
    let radius = corners.map(|corner| corner.as_dvec3().length()).fold(0.0, f64::max);
    for frame in 0..frame_count {
        let (position, scale) = track.place(frame);
        LENGTH.check(&format!("at frame {frame} a scale"), scale)?;
        let reach = position.length() + scale * radius;
        if reach > MAX_REACH {
            return Err(format!(
                "at frame {frame} a moving object is {reach:e} from the origin: at most {MAX_REACH:e} is allowed"
            ));
        }
    }
    Ok(())
}
