//! Tests of OBJ scenes.

use std::fs;

use proptest::prelude::*;

use super::mtl::Names;
use super::*;

fn read(text: &str) -> Result<(Geometry, Library), String> {
    let mut library = Library::default();
    let plain = library.add(Material::default());
    let read = read::parse(Path::new("x.obj"), text.as_bytes(), plain, &mut library);
    read.map(|geometry| (geometry, library)).map_err(|error| error.to_string())
}

fn spec(text: &str) -> Result<ObjSpec, String> {
    ron::Options::default()
        .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
        .from_str(text)
        .map_err(|error| error.to_string())
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const STILL: &str = "camera: (fov: Vertical(40), path: Still(eye: (0, 0, 5), look: At(0, 0, 0)))";

#[test]
fn polygons_become_fans_and_points_and_lines_nothing() {
    let (geometry, _) = read(&format!("{SQUARE}p 1\nl 1 2 3\nf 1 2 3 4\n")).unwrap();
    assert_eq!(geometry.len(), 2);
    assert_eq!(geometry.triangles[1].v, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(geometry.attributes[0].normals, None);
}

#[test]
fn corners_keep_their_own_normals_and_texture_coordinates() {
    let text =
        format!("{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/3/1\nf 1 3 4\nf -4//-1 -2//-1 -1//-1\n");
    let (geometry, _) = read(&text).unwrap();
    assert_eq!(geometry.len(), 3);
    assert_eq!(geometry.attributes[0].normals, Some([Vec3::Z; 3]));
    assert_eq!(geometry.attributes[0].uv[2], glam::Vec2::ONE);
    assert_eq!(geometry.attributes[1].normals, None, "no normal is borrowed from another face");
    assert_eq!(geometry.attributes[2].normals, Some([Vec3::Z; 3]));
    assert_eq!(geometry.triangles[2], geometry.triangles[1]);
}

#[test]
fn a_degenerate_triangle_is_kept() {
    assert_eq!(read(&format!("{SQUARE}f 1 1 2\nf 1 2 3\n")).unwrap().0.len(), 2);
}

#[test]
fn errors_name_the_line_and_what_is_wrong() {
    let error = |text: &str| read(text).unwrap_err();
    assert_eq!(error(SQUARE), "x.obj: there is no face (`f`) in it");
    assert_eq!(error("v 0 0 0\nv 0 nan 0\n"), "x.obj:2: \"nan\" is not a finite number");
    assert_eq!(error("v 0 0 1e39\n"), "x.obj:1: \"1e39\" is not a finite number");
    assert_eq!(error("v 0 0\n"), "x.obj:1: 2 numbers: at least 3 are needed");
    assert_eq!(error(&format!("{SQUARE}f 1 2 9\n")), "x.obj:5: vertex 9 is asked for, and there are 4");
    assert_eq!(
        error(&format!("{SQUARE}f 1/1 2/1 3/1\n")),
        "x.obj:5: texture coordinate 1 is asked for, and there are 0"
    );
    assert_eq!(error(&format!("{SQUARE}f 1 2 0\n")), "x.obj:5: \"0\" is not an index of a face's corner");
    assert_eq!(error(&format!("{SQUARE}f 1 2 -5\n")), "x.obj:5: \"-5\" is not an index of a face's corner");
    assert_eq!(error(&format!("{SQUARE}f 1 2\n")), "x.obj:5: a face of 2 corners: at least 3 are needed");
    assert!(error(&format!("{SQUARE}f 1//1 2 3\n")).starts_with("x.obj:5: the corners of a face"));
    assert!(error(&format!("mtllib none.mtl\n{SQUARE}f 1 2 3\n")).contains("cannot read none.mtl"));
}

#[test]
fn materials_come_from_the_library_that_the_file_names() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let load = || {
        let mut library = Library::default();
        let plain = library.add(Material::default());
        let read = read::read(&folder.path().join("a.obj"), plain, &mut library);
        read.map(|geometry| (geometry, library)).map_err(|error| error.to_string())
    };
    put("a.obj", &format!("mtllib a b.mtl\n{SQUARE}f 1 2 3\nusemtl red one\nf 1 3 4\n"));
    put("a b.mtl", "newmtl red one\nKd 1 0 0.5\nKs 0.1 0.2 0.3\nNs 20\nNi 1.5\nd 0.25\n");
    let (geometry, library) = load().unwrap();
    assert_eq!(geometry.attributes.iter().map(|a| a.material.0).collect::<Vec<_>>(), [0, 1]);
    let red = library.materials[1];
    assert_eq!((red.diffuse, red.specular), (Vec3::new(1.0, 0.0, 0.5), Vec3::new(0.1, 0.2, 0.3)));
    assert_eq!((red.shininess, red.index_of_refraction, red.transmittance), (20.0, 1.5, 0.75));

    put("a b.mtl", "newmtl red one\nKd 1 0\n");
    assert!(load().unwrap_err().ends_with("a b.mtl:2: 2 numbers: at least 3 are needed"));
    put("a b.mtl", "newmtl red one\nd 1.5\n");
    assert!(load().unwrap_err().ends_with("d of 1.5 is not allowed: numbers from 0 to 1 are"));
    put("a b.mtl", "newmtl blue\n");
    assert!(load().unwrap_err().ends_with("a.obj:7: no material is named \"red one\""));
    put("a b.mtl", "newmtl red one\nmap_Kd x.tga\n");
    assert!(load().unwrap_err().contains("map_Kd \"x.tga\" is not allowed"));
    put("a b.mtl", "newmtl red one\nmap_Kd x.png\n");
    assert!(load().unwrap_err().contains("x.png"));
    put("x.png", "no picture");
    assert!(load().is_err());

    let mut encoder = png::Encoder::new(fs::File::create(folder.path().join("x.png")).unwrap(), 2, 1);
    encoder.set_color(png::ColorType::GrayscaleAlpha);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&[7, 255, 200, 0]).unwrap();
    let (_, library) = load().unwrap();
    assert_eq!(library.textures[0], crate::scene::Texture { width: 2, height: 1, rgb: vec![[7; 3], [200; 3]] });
    assert_eq!(library.materials[1].texture, Some(crate::scene::TextureId(0)));
}

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

/// Words that OBJ and MTL files are made of, and some that break readers.
fn soup() -> impl Strategy<Value = String> {
    const WORDS: &[&str] = &[
        "v",
        "vt",
        "vn",
        "f",
        "l",
        "p",
        "o",
        "g",
        "s",
        "usemtl",
        "newmtl",
        "Kd",
        "Ks",
        "Ka",
        "Ke",
        "d",
        "Ns",
        "Ni",
        "illum",
        "map_Kd",
        "map_Bump",
        "a",
        "0",
        "1",
        "2",
        "-1",
        "0.5",
        "1e39",
        "nan",
        "1/1/1",
        "1//1",
        "2/",
        "/",
        "-1/-1/-1",
        "1/9223372036854775807/1",
        "1//6148914691236517206",
        "-9223372036854775808",
        "#",
        "\\",
        "\u{3000}",
        "é",
        "\t",
        "\r",
        "\n",
        "\n",
        "\n",
        "\nv 0 0 0\n",
        "\nvt 0 1\n",
        "\nvn 0 1 0\n",
        "\nf 1 1 1\n",
    ];
    proptest::collection::vec(proptest::sample::select(WORDS), 0..60).prop_map(|words| words.join(" "))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4096, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_make_the_readers_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mut library = Library::default();
        let _ = read::parse(Path::new("x.obj"), &bytes, MaterialId(0), &mut library);
        let _ = library.parse(Path::new("x.mtl"), &bytes, &mut Names::default());
    }

    #[test]
    fn no_words_make_the_readers_panic(text in soup()) {
        let mut library = Library::default();
        if let Ok(geometry) = read::parse(Path::new("x.obj"), text.as_bytes(), MaterialId(0), &mut library) {
            prop_assert!(!geometry.is_empty());
            prop_assert!(geometry.triangles.iter().all(|triangle| triangle.v.iter().all(|corner| corner.is_finite())));
        }
        let _ = library.parse(Path::new("x.mtl"), text.as_bytes(), &mut Names::default());
    }
}
