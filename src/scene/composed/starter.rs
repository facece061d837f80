//! A scene to start from: one file of triangles, seen from all sides.

use std::path::Path;

use glam::DVec3;

use super::files::FileSpec;
use crate::scene::error::SceneError;
use crate::scene::loader::Loader;
use crate::scene::model::append;
use crate::scene::obj::Libraries;

/// Endings of files that hold triangles.
const ENDINGS: [&str; 4] = ["obj", "ply", "gltf", "glb"];
/// Frames in which the camera goes a quarter of a circle around the middle.
const FRAMES: u32 = 48;
const KEYS: u32 = 4;
/// The camera's vertical angle of view, and how high above the middle it is, in degrees.
const VIEW: f64 = 45.0;
const HEIGHT: f64 = 25.0;

/// Whether the ending of `path` is that of a file of triangles.
pub(crate) fn is_mesh(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

/// The config, in RON, of a scene that shows the file `mesh`, which the config calls `name`. A camera moves around the
/// file's contents, and one light shines from above.
///
/// # Errors
/// The file cannot be read, or it holds no triangle of any size.
pub(crate) fn config(mesh: &Path, name: &str) -> Result<String, SceneError> {
    // Pictures have no effect on positions.
    let mut loader = Loader::default();
    loader.ignore_textures = true;
    let plain = loader.add_material(Default::default());
    let file = FileSpec::of(mesh.to_owned());
    let model = file.read(Path::new(""), plain, file.place(), &mut loader, &mut Libraries::default())?;
    let mut all = model.statics;
    for (geometry, pose) in &model.moving {
        append(&mut all, geometry, pose(0.0)).map_err(|what| SceneError::Content { path: mesh.into(), what })?;
    }
    let corners = all.triangles.iter().flat_map(|triangle| triangle.v).map(|corner| corner.as_dvec3());
    let (low, high) =
        corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corner| (low.min(corner), high.max(corner)));
    let (middle, radius) = ((low + high) / 2.0, low.distance(high) / 2.0);
    if !(radius.is_finite() && radius > 0.0) {
        return Err(SceneError::Content { path: mesh.into(), what: "it holds no triangle of any size".into() });
    }
    let digits = usize::try_from(2 - radius.log10().floor() as i32).unwrap_or(0);
    let point = |at: DVec3| format!("({:.digits$}, {:.digits$}, {:.digits$})", at.x, at.y, at.z);
    // At this distance the whole bounding sphere of the box is in view.
    let distance = radius / (VIEW / 2.0).to_radians().sin();
    let keys = (0..KEYS).map(|key| {
        let share = f64::from(key) / f64::from(KEYS - 1);
        let (around, up) = ((30.0 + 90.0 * share).to_radians(), HEIGHT.to_radians());
        let eye = middle + distance * DVec3::new(around.cos() * up.cos(), up.sin(), around.sin() * up.cos());
        let frame = (share * f64::from(FRAMES - 1)).round();
        format!("        (frame: {frame}, eye: {}, look: At{}),\n", point(eye), point(middle))
    });
    let light = middle + radius * DVec3::new(1.0, 2.0, 0.5);
    Ok(format!(
        "Files(\n    files: {name:?},\n    // In a hall or a room, put the lights and the camera inside.\n    \
         lights: [(position: {}, color: (0.9, 0.9, 0.9))],\n    \
         // Or the name of a camera of a glTF file.\n    \
         camera: (fov: Vertical({VIEW}), path: Keys([\n{}    ])),\n    \
         frame_count: {FRAMES},\n    background: (0.6, 0.7, 0.9),\n    ambient: (0.15, 0.15, 0.15),\n)\n",
        point(light),
        keys.collect::<String>()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_sees_all_of_a_file_from_every_side() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        std::fs::write(&path, "v 0 0 0\nv 20 0 0\nv 0 10 40\nf 1 2 3\n").unwrap();
        let text = config(&path, "a.obj").unwrap();
        assert!(text.contains("files: \"a.obj\"") && text.contains("At(10.0, 5.0, 20.0)"), "{text}");
        assert_eq!(text.matches("frame: ").count(), KEYS as usize);
        std::fs::write(&path, "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n").unwrap();
        assert!(config(&path, "a.obj").unwrap_err().to_string().contains("no triangle of any size"));
        assert!(is_mesh(Path::new("x/a.GLB")) && !is_mesh(Path::new("a.ron")) && !is_mesh(Path::new("obj")));
    }
}
