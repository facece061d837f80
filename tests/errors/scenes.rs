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
    insta::assert_snapshot!(floor(&desk, "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), @"error: floor.obj: there is no face (`f`) in it");
    insta::assert_snapshot!(floor(&desk, ""), @"error: floor.obj: there is no face (`f`) in it");
}

#[test]
fn a_missing_texture() {
    let desk = Desk::with_experiment();
    let textured = format!("mtllib floor.mtl\nusemtl wood\n{FLOOR}");
    insta::assert_snapshot!(floor(&desk, &textured), @r#"error: floor.obj:1: mtllib "floor.mtl": cannot read floor.mtl: No such file or directory (os error 2)"#);
    desk.put("floor.mtl", "newmtl wood\nKd 1 1 1\nmap_Kd wood.ppm\n");
    insta::assert_snapshot!(floor(&desk, &textured), @r#"error: floor.mtl:3: map_Kd "wood.ppm": cannot read wood.ppm: No such file or directory (os error 2)"#);
    desk.put("wood.ppm", "P6 2 2 255\nab");
    insta::assert_snapshot!(floor(&desk, &textured), @r#"error: floor.mtl:3: map_Kd "wood.ppm": wood.ppm: 2x2 pixels take 12 bytes: only 2 follow the header"#);
}

#[test]
fn statements_that_are_not_read() {
    let desk = Desk::with_experiment();
    insta::assert_snapshot!(floor(&desk, "v 0 0 0\nv 1 0 0\nv 0 1 0\nsurf 0 1 0 1 1 2 3\n"), @"error: floor.obj:4: `surf` is not allowed: free-form surfaces are not read");
    insta::assert_snapshot!(floor(&desk, "v 0 0 1.#INF\n"), @r#"error: floor.obj:1: "1.#INF" is not a finite number"#);
    insta::assert_snapshot!(floor(&desk, "v 0 0 1e10\n"), @"error: floor.obj:1: a point is at [0, 0, 10000000000]: at most 1e9 from the origin is allowed");
}

#[test]
fn what_has_no_effect_is_told_on_the_terminal_and_in_the_report() {
    let desk = Desk::with_experiment();
    desk.put("floor.obj", &format!("o floor\ng left\n{FLOOR}"));
    let run = desk.program(&["run", "tiny.ron", "--out", "report"]).output().unwrap();
    let told = "floor.obj: 2 kinds of statements have no effect: `g` (1), `o` (1)";
    assert!(String::from_utf8_lossy(&run.stderr).contains(&format!("note: {told}")), "{run:?}");
    let summary = std::fs::read_to_string(desk.path("report/summary.json")).unwrap();
    assert!(summary.contains(told), "{summary}");
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
    insta::assert_snapshot!(aff("zz 1 2 3\n"), @"error: room.aff:9: found `zz`: one of the commands v b l la am f fm s c p pp tt ttp tpa m i d xs x k a, or `}` after an open block, should be here");
}

#[test]
fn an_aff_file_with_a_missing_texture_or_file() {
    insta::assert_snapshot!(aff("f 1 1 1 1 0 1 0 0\ntt wood.ppm\n0 0 0\n0 0 0\n1 0 0\n1 0 0\n0 1 0\n0 1 0\n"), @"error: room.aff:10: texture `wood.ppm`: cannot read ../textures/wood.ppm: No such file or directory (os error 2)");
    insta::assert_snapshot!(aff("i absent.aff\n"), @"error: room.aff:9: found `absent.aff`: the level of an include, a whole number, should be here");
    insta::assert_snapshot!(aff("i 0 absent.aff\n"), @"error: room.aff:9: cannot include `absent.aff`: No such file or directory (os error 2)");
}

#[test]
fn an_absent_scene() {
    let desk = Desk::with_experiment();
    desk.put("scene.ron", "Aff(\"absent.aff\")");
    let told = desk.refused(&["validate", "tiny.ron"]);
    assert!(told.starts_with("error: scene.ron:1:6: cannot read absent.aff: No such file"), "{told}");
    std::fs::remove_file(desk.path("scene.ron")).unwrap();
    let told = desk.refused(&["validate", "tiny.ron"]);
    assert!(told.starts_with("error: tiny.ron:") && told.contains(": cannot read scene.ron: No such file"), "{told}");
}
