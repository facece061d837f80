//! glTF 2.0 files (`.gltf` with its buffers, `.glb`).
//!
//! Source: The Khronos Group, "glTF 2.0 Specification", 2021, and its extension `KHR_lights_punctual`. The crate
//! `gltf-json` gives the data model and checks it; indices, bounds and numbers are checked here, since the accessors of
//! the crate `gltf` panic on indices that no validation reaches.
//!
//! - Every mesh node of the scene becomes separate triangles, so a mesh is stored once per instance. Nodes that an
//!   animation moves, and all nodes below them, are dynamic. All others are static, also a node whose keys all have the
//!   same value.
//! - A camera has the name of its node. Point lights shine without attenuation, as all lights here do.
//! - Skins and morph targets are refused. A required extension that changes geometry is refused; notices list the
//!   others.

mod accessor;
mod animation;
mod buffers;
mod document;
mod materials;
mod mesh;
mod nodes;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use gltf_json::Root;
use gltf_json::extensions::scene::khr_lights_punctual;
use gltf_json::validation::Checked;

use self::buffers::Buffers;
use self::mesh::Meshes;
use self::nodes::Tree;
use super::camera::Projection;
use super::error::SceneError;
use super::limits::STRENGTH;
use super::loader::Loader;
use super::material::MaterialId;
use super::model::{FileCamera, FileLight, Model, append};

/// The contents of the glTF file at `path`, at `place`. Primitives without a material get `plain`; `animation` names
/// the animation that moves the nodes.
///
/// # Errors
/// A file that cannot be read or breaks the specification, an extension, skin or morph target that is not supported, a
/// picture that cannot be read, numbers out of range, a light that is no point light, an animation that does not exist.
pub(super) fn read(
    path: &Path,
    animation: Option<&str>,
    plain: MaterialId,
    place: DAffine3,
    loader: &mut Loader,
) -> Result<Model, SceneError> {
    let bytes = loader.files.read(path).map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    parse(path, &bytes, animation, plain, place, loader)
        .map_err(|what| SceneError::Content { path: path.to_owned(), what })
}

/// As [`read`], from the file's bytes.
fn parse(
    path: &Path,
    bytes: &[u8],
    animation: Option<&str>,
    plain: MaterialId,
    place: DAffine3,
    loader: &mut Loader,
) -> Result<Model, String> {
    let (root, chunk) = document::read(bytes, path, loader)?;
    let buffers = Buffers::read(&root, chunk, path, loader)?;
    let motions = animation::read(&root, &buffers, animation)?;
    let tree = Arc::new(Tree::new(&root, motions, place)?);
    if tree.held() > 0 {
        let what = format!("the animation holds {} nodes in one pose: they are static", tree.held());
        loader.notice(path, &what);
    }
    let mut meshes = Meshes::new(&root, &buffers, path, plain);
    let mut model = Model::default();
    for &index in tree.order() {
        let node = &root.nodes[index];
        let name = || document::name(&root, index);
        if node.skin.is_some() {
            return Err(format!("node {} has a skin: skins are not read", name()));
        }
        let pose = tree.pose(index);
        if let Some(mesh) = node.mesh {
            let geometry = meshes.get(mesh.value(), loader)?;
            if tree.moves(index) {
                model.moving.push((geometry.clone(), pose.clone()));
            } else {
                append(&mut model.statics, geometry, pose(0.0)).map_err(|what| format!("node {}: {what}", name()))?;
            }
        }
        if let Some(camera) = node.camera {
            let projection =
                projection(&root, camera.value()).map_err(|what| format!("camera of node {}: {what}", name()))?;
            let label = node.name.clone().unwrap_or_else(|| format!("node {index}"));
            model.cameras.push(FileCamera { name: label, projection, pose: pose.clone() });
        }
        let light = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        if let Some(light) = light
            && !loader.ignore_lights
        {
            let color =
                point_light(&root, light.light.value()).map_err(|what| format!("light of node {}: {what}", name()))?;
            model.lights.push(FileLight { color, pose, moves: tree.moves(index) });
        }
    }
    Ok(model)
}

fn projection(root: &Root, index: usize) -> Result<Projection, String> {
    let camera = root.cameras.get(index).ok_or("it is not there")?;
    if let Some(perspective) = &camera.perspective {
        let angle = f64::from(perspective.yfov);
        return if angle > 0.0 && angle < std::f64::consts::PI {
            Ok(Projection::Perspective { tan_half_fov: (0.5 * angle).tan() })
        } else {
            Err(format!("an angle of view of {angle} is not allowed: between 0 and pi is"))
        };
    }
    let parallel = camera.orthographic.as_ref().ok_or("it is neither perspective nor orthographic")?;
    let half_height = super::limits::LENGTH.check("`ymag`", parallel.ymag.into())?;
    // The camera's pose replaces this direction.
    Ok(Projection::Parallel { half_height, direction: DVec3::NEG_Z })
}

/// The colour and strength of a point light.
fn point_light(root: &Root, index: usize) -> Result<glam::Vec3, String> {
    let lights = root.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let light = lights.and_then(|lights| lights.lights.get(index)).ok_or("it is not there")?;
    match light.type_ {
        Checked::Valid(khr_lights_punctual::Type::Point) => {
            let color = DVec3::from_array(light.color.map(f64::from)) * f64::from(light.intensity);
            STRENGTH.check_color("its colour times its intensity", color)
        }
        _ => {
            Err("only point lights are read: `file_lights: Ignore` in the scene's config leaves all of them out".into())
        }
    }
}
