//! Tests of PLY files.

use super::*;
use crate::scene::material::Material;

fn read_bytes(bytes: &[u8]) -> Result<(Geometry, Vec<String>), String> {
    let mut loader = Loader::default();
    let plain = loader.add_material(Material::default());
    let read = parse(Path::new("x.ply"), bytes, plain, &mut loader).map_err(|error| error.to_string())?;
    Ok((read, loader.finish().2.notices))
}

const HEADER: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty float z\nproperty uchar red\n\
    element face 1\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\nend_header\n";
const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];

fn ascii() -> String {
    let vertices = CORNERS.map(|[x, y, z]| format!("{x} {y} {z} 200\n")).concat();
    format!("ply\nformat ascii 1.0\ncomment made by hand\n{HEADER}{vertices}4 0 1 2 3\n0\n")
}

fn binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{HEADER}").into_bytes();
    let mut put =
        |number: &[u8]| bytes.extend(number.iter().rev().filter(|_| big).chain(number.iter().filter(|_| !big)));
    for [x, y, z] in CORNERS {
        put(&(x as f32).to_le_bytes());
        put(&y.to_le_bytes());
        put(&(z as f32).to_le_bytes());
        put(&[200]);
    }
    put(&[4]);
    (0..4_i32).for_each(|index| put(&index.to_le_bytes()));
    put(&0_i32.to_le_bytes());
    bytes
}

#[test]
fn all_three_forms_hold_the_same_triangles() {
    let (geometry, notices) = read_bytes(ascii().as_bytes()).unwrap();
    let area: f32 = geometry.triangles.iter().map(|triangle| 0.5 * triangle.normal().length()).sum();
    assert_eq!((geometry.len(), area), (2, 1.0), "the polygon is concave");
    assert_eq!(notices, ["x.ply: 2 kinds of statements have no effect: `element edge` (1), `vertex red` (1)"]);
    for big in [false, true] {
        assert_eq!(read_bytes(&binary(big)).unwrap().0, geometry);
    }
}

#[test]
fn normals_and_texture_coordinates_are_read() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
        element face 1\nproperty list uchar uint vertex_index\nend_header\n\
        0 0 0 0 0 2 0.5 0.25\n1 0 0 0 0 2 1 0\n0 1 0 0 0 2 0 1\n3 0 1 2\n";
    let (geometry, notices) = read_bytes(text.as_bytes()).unwrap();
    let face = geometry.attributes[0];
    assert_eq!((face.normals, face.uv), (Some([Vec3::Z; 3]), [Vec2::new(0.5, 0.25), Vec2::X, Vec2::Y]));
    assert!(notices.is_empty());
}

#[test]
fn errors_say_what_is_wrong() {
    let error = |from: &str, to: &str| read_bytes(ascii().replace(from, to).as_bytes()).map(|_| ()).unwrap_err();
    assert!(error("4 0 1 2 3", "4 0 1 2 4").contains("face 0: vertex 4 is asked for, and there are 4"));
    assert!(error("4 0 1 2 3", "2 0 1").contains("face 0: 2 corners: from 3"));
    assert!(error("4 0 1 2 3", "4 0 1 2 -1").contains("vertex -1 is asked for"));
    assert!(error("2 0 0 200", "2e9 0 0 200").contains("vertex 1: a point is at"));
    assert!(error("2 0 0 200", "nan 0 0 200").starts_with("x.ply:"));
    assert!(error("2 0 0 200", "-1.#IND 0 0 200").starts_with("x.ply:"));
    assert!(error("element vertex 4", "element vertex 4000000000").contains("more than the file can hold"));
    assert!(
        error("element edge 1\nproperty int vertex1\n", "element nothing 9\n").contains("more than the file can hold")
    );
    assert!(error("element edge 1", "element tristrips 1").contains("are not read"));
    assert!(error("property float z", "property float w").contains("`x`, `y` and `z`"));
    assert!(error("vertex_indices", "indices").contains("`vertex_indices` or `vertex_index`"));
    assert!(error("ply\n", "plx\n").starts_with("x.ply"));
    let cut = &binary(false)[..binary(false).len() - 9];
    assert!(read_bytes(cut).is_err());
}
