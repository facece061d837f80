//! The AFF reader, command by command, on small scenes, and on files that are none.

#[path = "aff/motion.rs"]
mod motion;

use std::f64::consts::TAU;
use std::fs;

use glam::{Vec2, Vec3};
use proptest::prelude::*;
use tempfile::TempDir;
use umbrasim::scene::{Frame, Projection, Scene, SceneError, aff};

const VIEW: &str = "v from 0 0 5 at 0 0 0 up 0 1 0 angle 40 hither 0.01 resolution 800 600\n";
const PIXEL: &[u8] = b"P6 1 2 255\n\x01\x02\x03\x0A\x0B\x0C";
const TRIANGLE: &str = "p 3 0 0 0 1 0 0 0 1 0\n";

/// A folder of files, the first of them the scene.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let dir = TempDir::new().unwrap();
    for (name, bytes) in files {
        let path = dir.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    dir
}

fn load_files(files: &[(&str, &[u8])]) -> Result<Scene, SceneError> {
    let dir = folder(files);
    aff::load(&dir.path().join(files[0].0))
}

/// The scene of `text`, with a camera.
fn load(text: &str) -> Scene {
    load_files(&[("Small.aff", format!("{VIEW}{text}").as_bytes())]).unwrap()
}

/// The message for `text` after a line with a camera, without the file's folder.
fn error(text: &str) -> String {
    let message = load_files(&[("a.aff", format!("{VIEW}{text}").as_bytes())]).unwrap_err().to_string();
    message[message.find("a.aff").unwrap()..].to_owned()
}

fn at(scene: &Scene, frame: u32) -> Frame {
    scene.animation.frame(frame)
}

fn corners(scene: &Scene) -> Vec<Vec3> {
    scene.statics.triangles.iter().flat_map(|triangle| triangle.v).collect()
}

fn near(a: impl Into<Vec3>, b: impl Into<Vec3>) {
    let (a, b) = (a.into(), b.into());
    assert!(a.distance(b) < 1e-5, "{a} is not {b}");
}

#[test]
fn a_scene_without_extras_has_the_defaults() {
    let scene = load(&format!("l 1 2 3 {TRIANGLE}"));
    assert_eq!(scene.name, "small");
    assert_eq!((scene.background, scene.ambient), (Vec3::ZERO, Vec3::ONE));
    assert_eq!((scene.frame_count, scene.light_count, scene.dynamic_count), (1, 1, 0));
    let frame = at(&scene, 0);
    assert_eq!((frame.lights[0].position, frame.lights[0].color), (Vec3::new(1.0, 2.0, 3.0), Vec3::ONE));
    near(frame.camera.eye.as_vec3(), [0.0, 0.0, 5.0]);
    near(frame.camera.forward.as_vec3(), Vec3::NEG_Z);
    near(frame.camera.right.as_vec3(), Vec3::X);
    assert_eq!(frame.camera.projection, Projection::Perspective { tan_half_fov: (TAU / 18.0).tan() });
    assert_eq!(scene.materials, [Default::default()]);
}

#[test]
fn colours_of_background_ambient_and_lights() {
    let scene = load("b .1 .2 .3 am 2 3 4 l 0 0 0 .5 .6 .7 # comment\nl 0 0 0");
    assert_eq!((scene.background, scene.ambient), (Vec3::new(0.1, 0.2, 0.3), Vec3::new(2.0, 3.0, 4.0)));
    assert_eq!(at(&scene, 0).lights.iter().map(|l| l.color).collect::<Vec<_>>(), [Vec3::new(0.5, 0.6, 0.7), Vec3::ONE]);
    assert_eq!(load(&"l 0 0 0\n".repeat(64)).light_count, 64);
    assert!(error(&"l 0 0 0\n".repeat(65)).starts_with("a.aff:66: too many lights: at most 64"));
}

#[test]
fn materials_hold_until_the_next_across_blocks_and_are_kept_once() {
    let scene = load(&format!(
        "fm .1 .2 .3 .4 .5 .6 .7 .8 .9 10 .25 1.5 {TRIANGLE}
         xs 1 1 1 0 0 1 0 0 0 0 {{ f .5 1 .25 .5 .125 20 0 1 {TRIANGLE} }} {TRIANGLE}
         fm .1 .2 .3 .4 .5 .6 .7 .8 .9 10 .25 1.5 {TRIANGLE}"
    ));
    let ids: Vec<_> = scene.statics.attributes.iter().map(|attributes| attributes.material.0).collect();
    assert_eq!(ids, [0, 1, 1, 0]);
    let [fm, f] = scene.materials[..] else { panic!("two materials") };
    assert_eq!((fm.ambient, fm.diffuse), (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.4, 0.5, 0.6)));
    assert_eq!((fm.specular, fm.shininess), (Vec3::new(0.7, 0.8, 0.9), 10.0));
    assert_eq!((fm.transmittance, fm.index_of_refraction, fm.texture), (0.25, 1.5, None));
    assert_eq!((f.ambient, f.diffuse, f.specular), (f.diffuse, Vec3::new(0.25, 0.5, 0.125), Vec3::splat(0.125)));
    assert_eq!((f.shininess, f.transmittance, f.index_of_refraction), (20.0, 0.0, 1.0));
}

#[test]
fn polygons_become_fans() {
    let scene = load("p 4 0 0 0 1 0 0 1 1 0 0 1 0 pp 3 0 0 0 0 0 2 1 0 0 1 0 0 0 1 0 0 3 4");
    let [x, y] = [Vec3::X, Vec3::Y];
    assert_eq!(corners(&scene), [Vec3::ZERO, x, x + y, Vec3::ZERO, x + y, y, Vec3::ZERO, x, y]);
    assert_eq!(scene.statics.attributes[0].normals, None);
    let normals = scene.statics.attributes[2].normals.unwrap();
    assert_eq!(normals, [Vec3::Z, x, Vec3::new(0.0, 0.6, 0.8)]);
    assert!(error("p 2 0 0 0 1 0 0").contains("a.aff:2: found `2`: the number of corners, a whole number from 3"));
}

#[test]
fn concave_polygons_are_covered_once() {
    let dented = load("p 5 0 0 0 1 0 0 .9 .5 0 1 1 0 0 1 0");
    let area: f32 = dented.statics.triangles.iter().map(|triangle| 0.5 * triangle.normal().length()).sum();
    assert_eq!(dented.statics.len(), 3);
    assert!((area - 0.95).abs() < 1e-6, "{area}");
    let crossing = load("p 4 0 0 0 1 1 0 1 0 0 0 1 0");
    assert!(crossing.origin.notices.iter().any(|notice| notice.contains("line 2 crosses itself")));
}

#[test]
fn lines_end_as_on_all_systems() {
    let text = format!("{VIEW}# a comment\np 3 0 0 0 1 0 0 0 1 0\n% another\nzz");
    for end in ["\n", "\r", "\r\n"] {
        let bytes = format!("\u{feff}{}", text.replace('\n', end));
        let message = load_files(&[("a.aff", bytes.as_bytes())]).unwrap_err().to_string();
        assert!(message.contains("a.aff:5: found `zz`"), "{message}");
    }
}

#[test]
fn materials_and_lights_have_ranges() {
    for (line, expected) in [
        ("f 1 0 0 -1 0 0 0 1", "a.aff:2: a material's diffuse share of -1 is not allowed: a number from 0 to 1 is"),
        ("f 1 0 0 1 0 0 5 1", "a material's transmittance of 5"),
        ("f 1 0 0 1 0 0 -1 1", "a material's transmittance of -1"),
        ("f 1 0 0 1 0 0 .5 0", "a material's index of refraction of 0 is not allowed: a number from 0.001 to 10 is"),
        ("fm 1 0 0 1 0 0 1 0 0 1 .5 -1.5", "a material's index of refraction of -1.5"),
        ("fm 1 0 0 1 0 0 1 0 0 -1 0 1", "a material's shininess of -1"),
        ("fm 1 0 0 1 2 0 1 0 0 1 0 1", "a material's diffuse term of 2"),
        ("l 0 0 0 -1 1 1", "the colour of a light of -1"),
        ("b 0 -1 0", "the colour of the background of -1"),
        ("l 1e10 0 0", "found `1e10`"),
        ("l 0 0 -1.#IND", "found `-1.#IND`"),
        ("l 0 0 1.#INF", "found `1.#INF`"),
    ] {
        let message = error(line);
        assert!(message.contains(expected), "{message}");
    }
    // Where no light goes through, files have an index of 0.
    assert_eq!(load(&format!("f 1 1 1 1 0 0 0 0 {TRIANGLE}")).statics.len(), 1);
}

#[test]
fn what_has_no_effect_is_told_once() {
    let scene = load(&format!("d 1 i 2 none.aff i 2 none.aff {TRIANGLE}"));
    let [notice] = &scene.origin.notices[..] else { panic!("one sentence: {:?}", scene.origin.notices) };
    let expected =
        "3 kinds of statements have no effect: `hither` (1), `i above the level of detail` (2), `resolution` (1)";
    assert!(notice.ends_with(expected), "{notice}");
}

#[test]
fn a_zero_normal_shades_flat() {
    assert_eq!(load("pp 3 0 0 0 0 0 1 1 0 0 0 0 0 0 1 0 0 0 1").statics.attributes[0].normals, None);
}

#[test]
fn spheres_and_cones_become_triangles() {
    let scene = load("s 1 2 3 2 c 0 0 0 1 0 0 2 0.5");
    assert_eq!(scene.statics.len(), 960 + 64);
    let points = corners(&scene);
    assert!(points[..960 * 3].iter().all(|p| (p.distance(Vec3::new(1.0, 2.0, 3.0)) - 2.0).abs() < 1e-5));
    assert!(points[960 * 3..].iter().all(|p| (p.truncate().length() - (1.0 - 0.25 * p.z)).abs() < 1e-5));
    assert!(error("s 0 0 0 0").contains("a number from 1e-9 to 1e9 is"));
    assert!(error("c 1 1 1 1 1 1 1 1").contains("two points"));
    assert!(error("c 1 1 1 1 0 0 0 -1").contains("radii of one sign"));
    assert!(error("c 1 1 1 0 0 0 0 0").contains("radii of one sign"));
}

#[test]
fn textures_are_found_beside_the_scene_and_beside_its_folder() {
    let text = format!(
        "{VIEW} fm 1 1 1 1 1 1 0 0 0 1 0 1
        tt a.ppm 0 0 0 0 0  1 0 0 1 0  0 1 0 0 1
        ttp b.ppm 0 0 0 0 0 1 .5 .25  1 0 0 0 0 1 1 0  0 1 0 0 0 1 0 -7.5
        m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 3 texturecoords 2 a.ppm 0 0 1 1 triangles 1 0 1 2 0 0 0 1 0 1"
    );
    let scene = load_files(&[("aff/a.aff", text.as_bytes()), ("aff/a.ppm", PIXEL), ("textures/b.ppm", PIXEL)]).unwrap();
    // v = 0 is the file's first row, the last one here.
    assert_eq!(scene.textures[0].rgb, [[10, 11, 12], [1, 2, 3]]);
    assert_eq!((scene.textures[0].width, scene.textures[0].height, scene.textures.len()), (1, 2, 2));
    let textures: Vec<_> =
        scene.statics.attributes.iter().map(|a| scene.materials[a.material.0 as usize].texture.unwrap().0).collect();
    assert_eq!(textures, [0, 1, 0]);
    let [tt, ttp, m] = scene.statics.attributes[..] else { panic!("three triangles") };
    assert_eq!((tt.uv, tt.normals), ([Vec2::ZERO, Vec2::X, Vec2::Y], None));
    assert_eq!((ttp.uv[0], ttp.uv[2], ttp.normals), (Vec2::new(0.5, 0.25), Vec2::new(0.0, -7.5), Some([Vec3::Z; 3])));
    assert_eq!((m.uv, m.normals), ([Vec2::ONE, Vec2::ZERO, Vec2::ONE], Some([Vec3::Z; 3])));
}

#[test]
fn meshes_check_their_numbers() {
    let mesh = |rest: &str| format!("m\nvertices 3 0 0 0 1 0 0 0 1 0\n{rest}");
    assert_eq!(load(&mesh("triangles 2 0 1 2 2 1 0")).statics.len(), 2);
    assert_eq!(load(&mesh("triangles 0")).statics.len(), 0);
    assert_eq!(
        error(&mesh("triangles 1\n0 1 3")),
        "a.aff:5: found `3`: the number of a vertex, a whole number from 0 to 2, should be here"
    );
    assert!(error(&mesh("triangles 1 0 1 -1")).contains("found `-1`"));
    assert!(error(&mesh("normals 1 0 0 1 triangles 1 0 1 2 0 0 1")).contains("a whole number from 0 to 0"));
    assert!(error(&mesh("triangles 4294967295 0 1 2")).contains("the file ends where the number of a vertex"));
    assert!(error("m vertices 4000000000 0 0").contains("the file ends where a vertex should be"));
    assert!(error(&mesh("normals 1 0 0 1 normals 1 0 0 1")).contains("found `normals`: `normals`, then"));
    assert!(error("tt none.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1").starts_with("a.aff:2: texture `none.ppm`: cannot read"));
}

#[test]
fn static_transforms_scale_rotate_and_translate_and_nest() {
    let scene = load(&format!(
        "xs 2 3 4  0 0 5 90  10 0 0 {{ {TRIANGLE} xs 1 1 1 0 1 0 0 0 0 1 {{ {TRIANGLE} }} }} {TRIANGLE}"
    ));
    let found = corners(&scene);
    let expected =
        [[10.0, 0.0, 0.0], [10.0, 2.0, 0.0], [7.0, 0.0, 0.0], [10.0, 0.0, 4.0], [10.0, 2.0, 4.0], [7.0, 0.0, 4.0]];
    found.iter().zip(expected).for_each(|(found, expected)| near(*found, expected));
    assert_eq!(found[6..], [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert!(error("xs 1 1 1 0 0 0 90 0 0 0 { }").contains("the axis of a rotation is"));
    assert!(error("xs 1e9 1 1 0 0 1 0 1 0 0\n{ p 3 0 0 0 1 0 0 0 1 0 }").starts_with("a.aff:3: a point is at"));
}

#[test]
fn normals_follow_the_inverse_transpose() {
    let patch = "pp 3 0 0 0 1 1 0 1 0 0 1 1 0 0 1 0 1 1 0";
    let normal = |scale: &str| load(&format!("xs {scale} 0 0 1 0 0 0 0 {{ {patch} }}")).statics.attributes[0].normals;
    let unit = |x: f32, y: f32| Vec3::new(x, y, 0.0).normalize();
    near(normal("2 1 1").unwrap()[0], unit(0.5, 1.0));
    // A mirror keeps corners and their order; the normal is mirrored.
    near(normal("-2 1 1").unwrap()[1], unit(-0.5, 1.0));
    near(normal("1 0 1").unwrap()[2], Vec3::Y);
    assert_eq!(normal("0 0 1"), None);
}

#[test]
fn includes_inherit_blocks_and_share_the_material() {
    let main = format!(
        "{VIEW} i 0 red.aff x a {{ xs 1 1 1 0 0 1 0 0 0 2 {{ i 0 part.aff }} }} i 0 part.aff
         i 1 missing.aff d 1 i 1 part.aff"
    );
    let scene = load_files(&[
        ("a.aff", main.as_bytes()),
        ("red.aff", b"fm 1 0 0 1 0 0 0 0 0 1 0 1 % no newline"),
        ("part.aff", TRIANGLE.as_bytes()),
    ])
    .unwrap();
    assert_eq!((scene.statics.len(), scene.dynamic_count, scene.materials.len()), (2, 1, 1));
    assert_eq!(scene.materials[0].diffuse, Vec3::X);
    near(at(&scene, 0).dynamic.triangles[0].v[0], [0.0, 0.0, 2.0]);
}

#[test]
fn includes_that_are_missing_or_go_round_are_errors() {
    assert!(error("\n\ni 0 none.aff").starts_with("a.aff:4: cannot include `none.aff`: "));
    assert!(error("i 0 .").contains("a regular file is needed"));
    assert!(error("i 0 a.aff").starts_with("a.aff:2: `a.aff` includes itself"));
    let round = load_files(&[("a.aff", b"i 0 b.aff"), ("b.aff", b"\ni 0 a.aff")]).unwrap_err().to_string();
    assert!(round.ends_with("b.aff:2: `a.aff` includes itself"), "{round}");
    // Each file includes the next twice: not a circle, and too much all the same.
    let chain = |count: usize, each: usize| {
        let names: Vec<_> = (0..=count).map(|index| format!("{index}.aff")).collect();
        let texts: Vec<_> = names[1..].iter().map(|name| format!("i 0 {name}\n").repeat(each)).collect();
        let mut files: Vec<_> = names.iter().zip(&texts).map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
        files.push((&names[count], b""));
        load_files(&files).unwrap_err().to_string()
    };
    assert!(chain(33, 1).contains("includes are more than 32 deep"));
    assert!(chain(32, 1).contains("no camera"));
    assert!(chain(20, 2).contains("more than 65536 includes"));
}

#[test]
fn errors_say_what_is_allowed() {
    assert!(error("\nfrob 1").starts_with("a.aff:3: found `frob`: one of the commands v b l"));
    assert!(error("}").contains("no block is open"));
    assert!(error("x a {\n\n").starts_with("a.aff:4: the file ends in 1 open blocks"));
    assert!(error("x { }").contains("found `{`: the name of an animated transform should be here"));
    assert!(error("b 1 1 nan").contains("found `nan`"));
    assert!(error("a 0 1 0").contains("the number of frames, a whole number from 1"));
    assert!(error("a 1 0 5").contains("the end must not be before the start"));
    assert!(error("k a { transl 3 0 }").contains("the number of keys, a whole number from 4"));
    assert!(error("k a { spin 4 }").contains("found `spin`: `transl`, `rot`, `scale` or `visibility`"));
    assert!(error("k a { visibility 1 0 2 }").contains("a visibility, a whole number from 0 to 1"));
    assert!(
        error("k a { transl 4 2 0 0 0 0 0 0 1 1 0 0 0 0 0 2 0 0 0 0 0 0 3 0 0 0 0 0 0 }").contains("key 1 gives no")
    );
    let view = |from: &str, to: &str| {
        let text = VIEW.replace(from, to);
        load_files(&[("a.aff", text.as_bytes())]).unwrap_err().to_string()
    };
    assert!(view("angle 40", "angle 180").contains("180 degrees"));
    assert!(view("up 0 1 0", "up 0 0 2").contains("`up` must not run along"));
    assert!(view("at 0 0 0", "at 0 0 5").contains("`at` must differ"));
    assert!(view("800 600", "0 600").contains("the width of the picture"));
    assert!(view("from", "form").contains("found `form`: `from` should be here"));
    assert!(load_files(&[("a.aff", b"l 0 0 0")]).unwrap_err().to_string().contains("no camera"));
    assert!(matches!(aff::load("none/a.aff".as_ref()), Err(SceneError::Read { .. })));
}

/// A scene with every command.
const EVERYTHING: &str = "v from 0 0 5 at 0 0 0 up 0 1 0 angle 40 hither 0.01 resolution 8 6
b 0 0 1 am 1 1 1 l 0 3 0 l 1 3 0 .5 .5 .5 la lamp 0 2 0 f 1 1 1 .5 .5 9 0 1 s 0 0 0 1
fm .1 .1 .1 .5 .5 .5 .2 .2 .2 30 .5 1.5 c 0 0 0 1 0 1 0 0 p 3 0 0 0 1 0 0 0 1 0
pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 tt a.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1
tpa 2 0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 2 0 0 1 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1
x go { xs 2 2 2 0 1 0 45 0 0 1 { d 1 i 1 b.aff
m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1 texturecoords 1 a.ppm 0 0 triangles 1 0 1 2 0 0 0 0 0 0 } }
k go { transl 4 0 0 0 0 0 0 0 1 0 0 0 0 0 0 2 1 0 0 0 0 0 3 1 0 0 0 0 0
rot 4 0 0 1 0 0 0 0 0 1 0 1 0 10 0 0 0 2 0 1 0 20 0 0 0 3 0 1 0 30 0 0 0 visibility 1 1 0 } a 0 2 3 # end
";

/// Loads; a scene must then have frames of the size that it states.
fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    let files: [(&str, &[u8]); 3] = [("a.aff", bytes), ("a.ppm", PIXEL), ("b.aff", TRIANGLE.as_bytes())];
    if let Ok(scene) = load_files(&files) {
        for number in [0, 1, u32::MAX] {
            let frame = scene.animation.frame(number);
            prop_assert_eq!(frame.dynamic.len(), scene.dynamic_count);
            prop_assert_eq!(frame.visible.len(), scene.dynamic_count);
            prop_assert_eq!(frame.lights.len(), scene.light_count);
            prop_assert!(frame.dynamic.triangles.iter().all(|t| t.v.iter().all(|v| v.is_finite())));
        }
        prop_assert!(scene.statics.triangles.iter().all(|t| t.v.iter().all(|v| v.is_finite())));
    }
    Ok(())
}

#[test]
fn the_scene_of_everything_loads() {
    let files: [(&str, &[u8]); 3] =
        [("a.aff", EVERYTHING.as_bytes()), ("a.ppm", PIXEL), ("b.aff", TRIANGLE.as_bytes())];
    let scene = load_files(&files).unwrap();
    assert_eq!((scene.statics.len(), scene.dynamic_count, scene.light_count), (960 + 32 + 3, 3, 3));
}

proptest! {
    #[test]
    fn bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        check(&bytes)?;
    }

    #[test]
    fn words_never_panic(words in prop::collection::vec(
        prop::sample::select(EVERYTHING.split_whitespace().collect::<Vec<_>>()), 0..40,
    )) {
        check(format!("{VIEW}{}", words.join(" ")).as_bytes())?;
    }

    #[test]
    fn mutations_never_panic(
        cuts in prop::collection::vec((0..EVERYTHING.len(), 0usize..12, "[-0-9a-z{}#. \n]{0,6}"), 1..4)
    ) {
        let mut bytes = EVERYTHING.as_bytes().to_vec();
        for (at, length, insert) in cuts {
            let start = at.min(bytes.len());
            let end = (start + length).min(bytes.len());
            bytes.splice(start..end, insert.bytes());
        }
        check(&bytes)?;
    }

    #[test]
    fn other_numbers_never_panic(
        index in 0usize..300,
        number in prop_oneof![any::<f64>().prop_map(|x| x.to_string()), any::<i64>().prop_map(|x| x.to_string())],
    ) {
        let mut words: Vec<_> = EVERYTHING.split('#').next().unwrap_or_default().split_whitespace().collect();
        let numbers: Vec<_> = (0..words.len()).filter(|&i| words[i].parse::<f64>().is_ok()).collect();
        words[numbers[index % numbers.len()]] = &number;
        check(words.join(" ").as_bytes())?;
    }
}
