//! Scenes of which a part is missing or not understood.

use super::common::{Desk, FLOOR};

/// What a run says when the floor is another file.
fn floor(desk: &Desk, obj: &str) -> String {
    desk.put("floor.obj", obj);
    desk.refused(&["run", "tiny.ron", "--out", "report"])
}

#[test]
fn an_obj_without_faces() {
    let desk = Desk::with_experiment();
    insta::assert_snapshot!(floor(&desk, "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), @"");
    insta::assert_snapshot!(floor(&desk, ""), @"");
}

#[test]
fn a_missing_texture() {
    let desk = Desk::with_experiment();
    let textured = format!("mtllib floor.mtl\nusemtl wood\n{FLOOR}");
    insta::assert_snapshot!(floor(&desk, &textured), @"");
    desk.put("floor.mtl", "newmtl wood\nKd 1 1 1\nmap_Kd wood.ppm\n");
    insta::assert_snapshot!(floor(&desk, &textured), @"");
    desk.put("wood.ppm", "P6 2 2 255\nab");
    insta::assert_snapshot!(floor(&desk, &textured), @"");
}

/// What a run says of an AFF file with these lines after its camera and light.
fn aff(lines: &str) -> String {
    let desk = Desk::with_experiment();
    desk.put("scene.ron", "Aff(\"room.aff\")");
    let view = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 40\nhither 1\nresolution 16 16\nl 0 5 0\n";
    desk.put("room.aff", &format!("{view}{lines}"));
    desk.refused(&["run", "tiny.ron", "--out", "report"])
}

#[test]
fn an_aff_file_with_an_unknown_command() {
    insta::assert_snapshot!(aff("zz 1 2 3\n"), @"");
}

#[test]
fn an_aff_file_with_a_missing_texture_or_file() {
    insta::assert_snapshot!(aff("f 1 1 1 1 0 1 0 0\ntt wood.ppm\n0 0 0\n0 0 0\n1 0 0\n1 0 0\n0 1 0\n0 1 0\n"), @"");
    insta::assert_snapshot!(aff("i absent.aff\n"), @"");
}

#[test]
fn an_absent_scene() {
    let desk = Desk::with_experiment();
    desk.put("scene.ron", "Aff(\"absent.aff\")");
    insta::assert_snapshot!(desk.refused(&["validate", "tiny.ron"]), @"");
    std::fs::remove_file(desk.path("scene.ron")).unwrap();
    insta::assert_snapshot!(desk.refused(&["validate", "tiny.ron"]), @"");
}
