//! Tests of scenes of files.

use std::fs;
use std::path::Path;

use glam::DVec3;

use super::*;

fn spec(text: &str) -> Result<ComposedSpec, String> {
    let extensions = ron::extensions::Extensions::IMPLICIT_SOME | ron::extensions::Extensions::UNWRAP_VARIANT_NEWTYPES;
    let options = ron::Options::default().with_default_extension(extensions);
    let spec: ComposedSpec = options.from_str(text).map_err(|error| error.to_string())?;
    // A config survives being written out.
    assert_eq!(options.from_str::<ComposedSpec>(&options.to_string(&spec).unwrap()).unwrap(), spec);
    Ok(spec)
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const STILL: &str = "camera: (fov: Vertical(40), path: Still(eye: (0, 0, 5), look: At(0, 0, 0)))";

#[test]
fn a_scene_is_composed_of_a_file_and_moving_objects() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.obj"), format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    let text = format!(
        "(path: \"a.obj\", lights: [(position: (0, 0, 3))], {STILL}, frame_count: 11, moving: [
            (shape: Obj(\"a.obj\"), color: (1, 0, 0), path: [(frame: 0, position: (0, 0, 1)),
                (frame: 10, position: (5, 0, 1), rotation: 90, scale: 2)]),
            (shape: Sphere(radius: 0.5, segments: 8), path: [(frame: 0, position: (0, 2, 0))]),
            (shape: Box(size: (1, 2, 3)), path: [(frame: 3, position: (0, 0, 0))]),
        ])"
    );
    let scene = load(&spec(&text).unwrap(), folder.path()).unwrap();
    assert_eq!((scene.name.as_str(), scene.statics.len(), scene.light_count, scene.frame_count), ("a", 2, 1, 11));
    // A box of 1 x 2 x 3 with tiles of 3 has two triangles a side, a sphere of 8 segments 8 x (2 x 2 + 2).
    assert_eq!(scene.dynamic_count, 2 + 48 + 12);
    let (first, last) = (scene.animation.frame(0), scene.animation.frame(10));
    assert_eq!(first.dynamic.len(), scene.dynamic_count);
    assert_eq!(first.dynamic.triangles[0].v[1], Vec3::new(1.0, 0.0, 1.0));
    // Turned by 90 degrees about +Y, +X points to -Z.
    assert!((last.dynamic.triangles[0].v[1] - Vec3::new(5.0, 0.0, -1.0)).length() < 1e-6);
    assert_eq!(first.dynamic.triangles[2..], last.dynamic.triangles[2..]);
    assert_eq!(scene.materials[first.dynamic.attributes[0].material.0 as usize].diffuse, Vec3::X);
}

#[test]
fn configs_out_of_range_are_refused_while_they_are_read() {
    let with = |more: &str| spec(&format!("(path: \"a.obj\", lights: [], {STILL}{more})"));
    assert!(with("").is_ok());
    assert!(with(", lamps: []").unwrap_err().contains("lamps"));
    assert!(with(", frame_count: 0").is_err());
    assert!(with(", ambient: (0.1, -1, 0)").is_err());
    let moving = |moving: &str| with(&format!(", moving: [(shape: {moving})]"));
    assert!(moving("Sphere(radius: 1), path: [(frame: 0, position: (0, 0, 0))]").is_ok());
    assert!(moving("Sphere(radius: 0), path: [(frame: 0, position: (0, 0, 0))]").is_err());
    assert!(moving("Sphere(radius: 1), path: []").is_err());
    assert!(
        moving("Sphere(radius: 1), path: [(frame: 2, position: (0, 0, 0)), (frame: 1, position: (0, 0, 0))]").is_err()
    );
    let lights = "(position: (0, 0, 0)),".repeat(65);
    assert!(spec(&format!("(path: \"a.obj\", lights: [{lights}], {STILL})")).unwrap_err().contains("at most 64"));
}

#[test]
fn a_missing_file_is_named() {
    let spec = spec(&format!("(path: \"none.obj\", lights: [], {STILL})")).unwrap();
    let error = load(&spec, Path::new("nowhere")).unwrap_err();
    assert!(matches!(error, SceneError::Read { .. }));
    assert!(error.to_string().contains("none.obj"));
}

#[test]
fn files_have_places() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.obj"), format!("{SQUARE}vn 1 0 0\nf 1//1 2//1 3//1\n")).unwrap();
    fs::write(
        folder.path().join("b.ply"),
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    )
    .unwrap();
    let load_files = |files: &str| {
        let spec = spec(&format!("(files: {files}, lights: [], {STILL})")).unwrap();
        load(&spec, folder.path()).map_err(|error| error.to_string())
    };
    let scene = load_files(
        "[\"a.obj\", (path: \"b.ply\", translate: (0, 0, 7)), 
         (path: \"a.obj\", scale: 2, rotate: (0, 0, 90), translate: (5, 0, 0))]",
    );
    let scene = scene.unwrap();
    assert_eq!((scene.name.as_str(), scene.statics.len(), scene.origin.sources.len()), ("a", 3, 2));
    let corners: Vec<_> = scene.statics.triangles.iter().map(|triangle| triangle.v[1]).collect();
    assert_eq!(corners[..2], [Vec3::X, Vec3::new(1.0, 0.0, 7.0)]);
    // Scaled to 2 along x, turned to y, moved along x.
    assert!(corners[2].distance(Vec3::new(5.0, 2.0, 0.0)) < 1e-6, "{}", corners[2]);
    let normal = scene.statics.attributes[2].normals.unwrap()[0];
    assert!(normal.distance(Vec3::Y) < 1e-6, "{normal}");
    assert!(load_files("\"c.stl\"").unwrap_err().contains("must end in .obj"));
    assert!(load_files("(path: \"a.obj\", scale: 3)").is_ok());
    assert!(spec(&format!("(files: [], {STILL})")).unwrap_err().contains("at least one"));
    let far = load_files("[(path: \"a.obj\", scale: 1e9, translate: (1e9, 0, 0))]").unwrap_err();
    assert!(far.contains("at most 1e9 from the origin"), "{far}");
    assert!(load_files("[(path: \"a.obj\", animation: \"walk\")]").unwrap_err().contains("only a glTF file"));
}

#[test]
fn what_a_config_moves_too_far_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.obj"), format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    let moving = |path: &str| {
        let text = format!(
            "(path: \"a.obj\", lights: [], {STILL}, frame_count: 11, moving: [(shape: Obj(\"a.obj\"), path: [{path}])])"
        );
        load(&spec(&text)?, folder.path()).map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(moving("(frame: 0, position: (1e8, 0, 0), scale: 1e8)"), Ok(()));
    assert!(moving("(frame: 0, position: (1e39, 0, 0))").unwrap_err().contains("from -1e9 to 1e9"));
    assert!(moving("(frame: 0, position: (0, 0, 0), scale: 1e9)").unwrap_err().contains("at frame 0"));
    let shrinks = "(frame: 0, position: (0, 0, 0), scale: 1), (frame: 5, position: (0, 0, 0), scale: 0.01),
        (frame: 10, position: (0, 0, 0), scale: 1e-9)";
    assert!(moving(shrinks).unwrap_err().contains("a scale of"), "the curve overshoots below 0");
}

#[test]
fn a_gltf_file_brings_its_camera_lights_and_motion() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/gltf");
    let load_with = |more: &str| {
        let text =
            format!("(files: \"yard.gltf\", frame_count: 3, frame_rate: 1, lights: [(position: (0, 9, 0))]{more})");
        load(&spec(&text)?, &folder).map_err(|error| error.to_string())
    };
    let scene = load_with(", camera: \"eye\"").unwrap();
    assert_eq!((scene.statics.len(), scene.dynamic_count, scene.light_count), (43, 31, 2));
    let [first, second] = [0, 1].map(|number| scene.animation.frame(number));
    assert_eq!((first.camera.eye, first.camera), (DVec3::new(0.0, 2.0, 12.0), second.camera));
    // The lamp of the config, then that of the file.
    assert_eq!(first.lights[1], Light { position: Vec3::Y * 6.0, color: Vec3::new(2.0, 1.0, 0.5) });
    // The flag's first corner is the last node's origin; it jumps at half a second.
    let flag = |frame: &crate::scene::frame::Frame| frame.dynamic.triangles[24].v[0];
    assert_eq!([flag(&first), flag(&second)], [Vec3::splat(5.0), Vec3::new(5.0, 7.0, 5.0)]);
    assert_eq!(load_with(", camera: \"eye\", file_lights: Ignore").unwrap().light_count, 1);
    assert!(load_with(", camera: \"ear\"").unwrap_err().contains("no camera is named \"ear\": \"eye\""));
    assert!(
        load_with(&format!(
            ", {STILL}, moving: [(shape: File(\"yard.gltf\"), path: [(frame: 0, position: (0, 0, 0))])]"
        ))
        .unwrap_err()
        .contains("with an animation")
    );
}
