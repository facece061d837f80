//! Tests of OBJ files and material libraries.

use std::fs;

use super::*;
use crate::scene::material::{Material, Texture};

fn read_bytes(bytes: &[u8]) -> Result<(Geometry, Loader), String> {
    let (mut loader, mut libraries) = (Loader::default(), Libraries::default());
    let plain = loader.add_material(Material::default());
    let read = parse(Path::new("x.obj"), bytes, plain, &mut loader, &mut libraries);
    read.map(|geometry| (geometry, loader)).map_err(|error| error.to_string())
}

fn read_text(text: &str) -> Result<(Geometry, Loader), String> {
    read_bytes(text.as_bytes())
}

fn error(text: &str) -> String {
    read_text(text).map(|_| ()).unwrap_err()
}

fn area(geometry: &Geometry) -> f32 {
    geometry.triangles.iter().map(|triangle| 0.5 * triangle.normal().length()).sum()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_become_triangles_and_points_and_lines_nothing() {
    let (geometry, loader) = read_text(&format!("{SQUARE}p 1\nl 1 2 3\nf 1 2 3 4\n")).unwrap();
    assert_eq!(geometry.len(), 2);
    assert_eq!(geometry.triangles[1].v, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
    assert_eq!(geometry.attributes[0].normals, None);
    assert_eq!(loader.finish().2.notices, ["x.obj: 2 kinds of statements have no effect: `l` (1), `p` (1)"]);
}

#[test]
fn concave_polygons_are_covered_once() {
    let dented = format!("{SQUARE}v 0.9 0.5 0\nf 1 2 5 3 4\n");
    assert!((area(&read_text(&dented).unwrap().0) - 0.95).abs() < 1e-6);
    let crossing = format!("{SQUARE}f 1 3 2 4\n");
    assert!(read_text(&crossing).unwrap().1.finish().2.notices[0].contains("1 faces cross themselves"));
}

#[test]
fn corners_keep_their_own_normals_and_texture_coordinates() {
    let text =
        format!("{SQUARE}vt 0 0\nvt 1\nvt 1 1 9\nvn 0 0 2\nf 1/1/1 2/2/1 3/3/1\nf 1 3 4\nf -4//-1 -2//-1 -1//-1\n");
    let (geometry, _) = read_text(&text).unwrap();
    assert_eq!(geometry.len(), 3);
    assert_eq!(geometry.attributes[0].normals, Some([Vec3::Z; 3]));
    assert_eq!(geometry.attributes[0].uv, [Vec2::ZERO, Vec2::X, Vec2::ONE]);
    assert_eq!(geometry.attributes[1].normals, None, "no normal is borrowed from another face");
    assert_eq!(geometry.attributes[2].normals, Some([Vec3::Z; 3]));
    assert_eq!(geometry.triangles[2], geometry.triangles[1]);
}

#[test]
fn negative_indices_count_from_the_face_back_whatever_the_object() {
    let text = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\no b\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf -3 -2 -1\nf 1 2 3\n";
    let (geometry, _) = read_text(text).unwrap();
    let heights: Vec<_> = geometry.triangles.iter().map(|triangle| triangle.v[0].z).collect();
    assert_eq!(heights, [0.0, 1.0, 0.0]);
    // A face may stand before its vertices.
    assert_eq!(read_text(&format!("f 1 2 3\n{SQUARE}")).unwrap().0.len(), 1);
}

#[test]
fn a_degenerate_triangle_is_kept() {
    assert_eq!(read_text(&format!("{SQUARE}f 1 1 2\nf 1 2 3\n")).unwrap().0.len(), 2);
}

#[test]
fn lines_of_all_systems_and_their_joints_are_read() {
    let plain = read_text(&format!("{SQUARE}f 1 2 3 4\n")).unwrap().0;
    for text in [
        format!("\u{feff}{SQUARE}f 1 2 3 4"),
        format!("{SQUARE}# comment\nf 1 2 3 4 # comment\n").replace('\n', "\r"),
        format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r\n"),
        format!("{SQUARE}f 1 2 \\\n 3 4\n"),
        format!("{SQUARE}fo 1 2 3 4\n"),
        format!("{SQUARE}f\t1\t2 3  4  ").replace("v 0 0", "v 0\t0"),
        format!("{SQUARE}f 1// 2/ 3 4\n"),
        SQUARE.replace(" 0\n", " 0 1.0\n") + "f 1 2 3 4\n",
        SQUARE.replace(" 0\n", " 0 0.5 0.5 1\n") + "f 1 2 3 4\n",
    ] {
        assert_eq!(read_text(&text).map(|(geometry, _)| geometry), Ok(plain.clone()), "{text:?}");
    }
    assert!(read_bytes(b"o \xFF\xFE\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").is_ok(), "names are of any encoding");
}

#[test]
fn errors_name_the_line_and_what_is_wrong() {
    assert_eq!(error(SQUARE), "x.obj: there is no face (`f`) in it");
    assert_eq!(error("v 0 0 0\nv 0 nan 0\n"), "x.obj:2: \"nan\" is not a finite number");
    assert_eq!(error("v 0 0 1e39\n"), "x.obj:1: \"1e39\" is not a finite number");
    assert_eq!(error("v 0 0 -1.#IND\n"), "x.obj:1: \"-1.#IND\" is not a finite number");
    assert_eq!(error("v 0 0 1\0\n"), "x.obj:1: \"1\\0\" is not a finite number");
    assert!(error("v 0 0 1e10\n").starts_with("x.obj:1: a point is at [0, 0, 10000000000]: at most 1e9"));
    assert_eq!(error("v 0 0\n"), "x.obj:1: a vertex of 2 numbers: x y z, with a weight or a colour, is");
    assert_eq!(error("v 0 0 0 0.5\n"), "x.obj:1: a vertex of weight 0.5: 1 or none is allowed");
    assert_eq!(error("vt\n"), "x.obj:1: texture coordinates are u, u v or u v w");
    assert_eq!(error("vn 1 2\n"), "x.obj:1: a normal of 2 numbers: 3 are");
    assert_eq!(error("v 0 0 0 1 1 1 1 1\n"), "x.obj:1: 8 numbers: at most 7 are allowed");
    assert_eq!(error(&format!("{SQUARE}f 1 2 9\n")), "x.obj:5: vertex 9 is asked for, and there are 4");
    assert_eq!(
        error(&format!("{SQUARE}f 1/1 2/1 3/1\n")),
        "x.obj:5: texture coordinate 1 is asked for, and there are 0"
    );
    assert_eq!(error(&format!("{SQUARE}f 1 2 0\n")), "x.obj:5: \"0\" is not an index of a face's corner");
    assert_eq!(error(&format!("{SQUARE}f 1 2 -5\n")), "x.obj:5: \"-5\" is not an index of a face's corner");
    assert_eq!(error(&format!("{SQUARE}f 1 2 3.0\n")), "x.obj:5: \"3.0\" is not an index of a face's corner");
    assert_eq!(error(&format!("{SQUARE}f 1 2\n")), "x.obj:5: a face of 2 corners: at least 3 are needed");
    assert!(error(&format!("{SQUARE}f 1//1 2 3\n")).starts_with("x.obj:5: normal 1 is asked for"));
    assert!(error(&format!("{SQUARE}vn 0 0 1\nf 1//1 2 3\n")).starts_with("x.obj:6: the corners of a face"));
    assert!(error(&format!("{SQUARE}vt 0\nvn 0 0 1\nf 1/1/1/1 2 3\n")).contains("v, v/vt, v//vn or v/vt/vn is"));
    assert!(
        error(&format!("mtllib none.mtl\n{SQUARE}f 1 2 3\n")).starts_with("x.obj:1: mtllib \"none.mtl\": cannot read")
    );
}

#[test]
fn statements_that_would_be_lost_are_refused() {
    let unknown = error(&format!("{SQUARE}F 1 2 3\n"));
    assert!(unknown.starts_with("x.obj:5: `F` is no statement of an OBJ file: v, vt, vn, f, mtllib"), "{unknown}");
    for statement in ["surf 0 1 0 1 1 2 3", "call b.obj", "csh rm", "bzp 1 2", "shadow_obj a.obj", "trace_obj a.obj"] {
        let refused = error(&format!("{SQUARE}{statement}\n"));
        assert!(refused.starts_with("x.obj:5: `") && refused.contains("is not allowed"), "{refused}");
    }
    for statement in statements::WITHOUT_EFFECT {
        assert!(read_text(&format!("{SQUARE}{statement} 1\nf 1 2 3\n")).is_ok(), "{statement}");
    }
}

/// A folder with `a.obj`.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(head: &str, use_line: &str) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.put("a.obj", &format!("{head}\n{SQUARE}f 1 2 3\n{use_line}\nf 1 3 4\n"));
        folder
    }

    fn put(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(name), text).unwrap();
    }

    fn load(&self) -> Result<(Geometry, Loader), String> {
        let (mut loader, mut libraries) = (Loader::default(), Libraries::default());
        let plain = loader.add_material(Material::default());
        let read = read(&self.0.path().join("a.obj"), plain, &mut loader, &mut libraries);
        read.map(|geometry| (geometry, loader)).map_err(|error| error.to_string())
    }

    /// The diffuse colour of the second face.
    fn color(&self) -> Result<Vec3, String> {
        let (geometry, loader) = self.load()?;
        Ok(loader.materials[geometry.attributes[1].material.0 as usize].diffuse)
    }

    fn error(&self) -> String {
        self.load().map(|_| ()).unwrap_err()
    }
}

#[test]
fn materials_come_from_the_library_that_the_file_names() {
    let folder = Folder::new("mtllib a b.mtl", "usemtl red one");
    folder.put("a b.mtl", "newmtl red one\nKd 1 0 0.5\nKs 0.1 0.2 0.3\nNs 20\nNi 1.5\nd 0.25\n");
    let (geometry, loader) = folder.load().unwrap();
    assert_eq!(geometry.attributes.iter().map(|a| a.material.0).collect::<Vec<_>>(), [0, 1]);
    let red = loader.materials[1];
    assert_eq!((red.diffuse, red.specular), (Vec3::new(1.0, 0.0, 0.5), Vec3::new(0.1, 0.2, 0.3)));
    assert_eq!((red.shininess, red.index_of_refraction, red.transmittance), (20.0, 1.5, 0.75));

    for (text, expected) in [
        ("newmtl red one\nKd 1 0\n", "b.mtl:2: `Kd` of 2 numbers: red, green and blue are needed"),
        ("newmtl red one\nd 1.5\n", "b.mtl:2: `d` of 1.5 is not allowed: a number from 0 to 1 is"),
        ("newmtl red one\nNi 0\n", "b.mtl:2: `Ni` of 0 is not allowed: a number from 0.001 to 10 is"),
        ("newmtl red one\nNs 1.#INF\n", "b.mtl:2: \"1.#INF\" is not a finite number"),
        ("newmtl blue\n", "a.obj:7: no material is named \"red one\""),
        ("<html>\n", "b.mtl:1: `<html>` is no statement of a material library"),
        ("", "a.obj:7: no material is named \"red one\""),
        ("Kd 1 0 0\nnewmtl red one\n", "b.mtl:1: `Kd` stands before the first `newmtl`"),
        ("\nnewmtl\n", "b.mtl:2: `newmtl` needs a name"),
        ("newmtl red one\nKd 1 1 1\nnewmtl red one\n", "b.mtl:3: a material \"red one\" is defined already"),
        ("newmtl red one\nmap_Kd\n", "b.mtl:2: `map_Kd` needs the name of a picture"),
        ("newmtl red one\nmap_Kd x.png\n", "b.mtl:2: map_Kd \"x.png\": cannot read"),
    ] {
        folder.put("a b.mtl", text);
        let error = folder.error();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn names_are_found_with_and_without_comments() {
    for (library, used) in [
        ("newmtl red", "usemtl red # comment"),
        ("newmtl red # comment", "usemtl red"),
        ("newmtl red # comment", "usemtl red # another"),
        ("newmtl red\t", "usemtl \tred"),
        ("newmtl Material #25", "usemtl Material #25"),
        ("newmtl \u{feff}red", "usemtl \u{feff}red"),
    ] {
        let folder = Folder::new("mtllib a.mtl # comment", used);
        folder.put("a.mtl", &format!("{library}\r\nKd 1 0 0\r\nnewmtl Material #26\r\n"));
        assert_eq!(folder.color(), Ok(Vec3::X), "{library} {used}");
    }
    // Two materials share the part before the comment: neither is meant.
    let folder = Folder::new("mtllib a.mtl", "usemtl Material");
    folder.put("a.mtl", "newmtl Material #25\nnewmtl Material #26\n");
    assert!(folder.error().contains("no material is named \"Material\""));
}

#[test]
fn several_libraries_are_searched_in_order_from_anywhere() {
    let folder = Folder::new("usemtl red\nmtllib a.mtl b.mtl", "usemtl red");
    folder.put("a.mtl", "newmtl blue\nKd 0 0 1\n");
    assert!(
        folder
            .error()
            .starts_with(&folder.0.path().join("a.obj:2: mtllib \"b.mtl\": cannot read").display().to_string())
    );
    folder.put("b.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 1 0\n");
    let (geometry, loader) = folder.load().unwrap();
    let colors = geometry.attributes.iter().map(|face| loader.materials[face.material.0 as usize].diffuse);
    assert_eq!(colors.collect::<Vec<_>>(), [Vec3::X; 2], "`usemtl` stands before `mtllib`");
    let folder = Folder::new("", "usemtl red");
    assert!(folder.load().unwrap().1.finish().2.notices[0].contains("`usemtl without a mtllib` (1)"));
}

#[test]
fn a_library_is_read_once_however_often_it_is_named() {
    let folder = Folder::new(&"mtllib a.mtl\n".repeat(40), "usemtl red");
    folder.put("a.mtl", "newmtl red\nKd 1 0 0\nmap_Kd x.ppm\n");
    folder.put("x.ppm", "P6 1 1 255\nabc");
    let (_, loader) = folder.load().unwrap();
    assert_eq!((loader.materials.len(), loader.textures.len()), (2, 1));
    assert_eq!(loader.finish().2.sources.len(), 3);
}

#[test]
fn statements_of_a_library_are_read_as_they_are_meant() {
    let folder = Folder::new("mtllib a.mtl", "usemtl red");
    let transmittance = |lines: &str| {
        folder.put("a.mtl", &format!("newmtl red\n{lines}\n"));
        let (_, loader) = folder.load().unwrap();
        (loader.materials[1].transmittance, loader.finish().2.notices)
    };
    assert_eq!(transmittance("Tr 0.75"), (0.75, vec![]));
    assert_eq!(transmittance("d 0.25\nTr 0.75"), (0.75, vec![]));
    let (found, notices) = transmittance("Tr 1\nd 1");
    assert_eq!(found, 0.0);
    assert!(notices[0].contains("`d` counts"), "{notices:?}");
    folder.put("a.mtl", "newmtl red\nkd 0.5\nillum 2\nKa 1 1 1\nPr 0.5\nmap_Bump -bm 1 a.png\n");
    assert_eq!(folder.color(), Ok(Vec3::splat(0.5)));
    let notices = folder.load().unwrap().1.finish().2.notices;
    assert!(
        notices[0].ends_with("4 kinds of statements have no effect: `Ka` (1), `Pr` (1), `illum` (1), `map_Bump` (1)")
    );
}

#[test]
fn pictures_are_found_and_placed() {
    let folder = Folder::new("mtllib a.mtl", "usemtl red");
    folder.put("a.mtl", "newmtl red\nmap_kd -s 2 2 1 textures\\x y.ppm # comment\n");
    folder.put("a.obj", &format!("mtllib a.mtl\n{SQUARE}vt 0.5 1\nusemtl red\nf 1/1 2/1 3/1\n"));
    fs::create_dir(folder.0.path().join("textures")).unwrap();
    folder.put("textures/x y.ppm", "P6 1 1 255\nabc");
    let (geometry, loader) = folder.load().unwrap();
    assert_eq!(loader.textures, [Texture { width: 1, height: 1, rgb: vec![[b'a', b'b', b'c']] }]);
    assert_eq!(geometry.attributes[0].uv[0], Vec2::new(1.0, 2.0));
    folder.put("textures/x y.ppm", "GIF89a");
    assert!(
        folder.error().ends_with("x y.ppm: the picture is neither a PNG nor a binary PPM (`P6`): only these are read")
    );
}
