//! What moves: transforms, visibility, poses, lights and the camera by keyframes.

use glam::Vec3;

use super::{TRIANGLE, at, error, load, near};

#[test]
fn animated_transforms_nest_and_share_keyframes_that_come_later() {
    let hold = "transl 4  0 9 0 0 0 0 0  1 9 0 0 0 0 0  2 9 0 0 0 0 0  3 9 0 0 0 0 0";
    let scene = load(&format!(
        "{TRIANGLE} x none {{ {TRIANGLE} x go {{ xs 1 1 1 0 0 1 90 0 0 1 {{ x go {{ {TRIANGLE} }} }} }} }}
         k go {{ {hold} rot 4  0 0 0 1 90 0 0 0  1 0 0 1 90 0 0 0  2 0 0 1 90 0 0 0  3 0 0 1 90 0 0 0 }}
         k go {{ transl 4  -1 -1 0 0 0 0 0  0 0 0 0 0 0 0  2 2 0 0 0 0 0  3 3 0 0 0 0 0 }}
         a 0 2 3"
    ));
    assert_eq!((scene.statics.len(), scene.dynamic_count, scene.frame_count), (1, 2, 3));
    for (number, x) in [(0, 0.0), (1, 1.0), (2, 2.0), (9, 2.0)] {
        let frame = at(&scene, number);
        assert_eq!(frame.number, number);
        // No keyframes: still, and yet of the part that can move.
        near(frame.dynamic.triangles[0].v[1], Vec3::X);
        // The inner motion along x turns into one along y.
        near(frame.dynamic.triangles[1].v[0], [x, x, 1.0]);
        assert_eq!(frame.visible, [true, true]);
    }
}

#[test]
fn visibility_counts_through_the_whole_chain() {
    let scene = load(&format!(
        "x a {{ {TRIANGLE} x b {{ {TRIANGLE} }} }}
         k a {{ visibility 2  1 0  3 1 }} k b {{ visibility 1 4 0 }} a 0 5 6"
    ));
    let seen: Vec<_> = (0..6).map(|number| at(&scene, number).visible).collect();
    assert_eq!(seen, [[true; 2], [false; 2], [false; 2], [true; 2], [true, false], [true, false]]);
}

#[test]
fn morphing_triangles_run_between_poses() {
    let pose = |x: f32, n: &str| format!("{x} 0 0 {n}  {} 0 0 {n}  {x} 1 0 {n}", x + 1.0);
    let scene = load(&format!(
        "xs 1 1 1 0 0 1 0 0 0 7 {{ tpa 3 1 {} 3 {} 3 {} }} a 0 4 9",
        pose(0.0, "0 0 1"),
        pose(4.0, "0 2 0"),
        pose(10.0, "0 2 0")
    ));
    assert_eq!((scene.statics.len(), scene.dynamic_count), (0, 1));
    for (number, x) in [(0, 0.0), (2, 0.0), (3, 1.0), (5, 3.0), (6, 10.0), (8, 10.0)] {
        near(at(&scene, number).dynamic.triangles[0].v[0], [x, 0.0, 7.0]);
    }
    let normals = at(&scene, 3).dynamic.attributes[0].normals.unwrap();
    near(normals[2], Vec3::new(0.0, 0.5, 0.75).normalize());
    assert!(error("tpa 0").contains("the number of poses"));
}

#[test]
fn keyframes_move_lights_and_the_camera() {
    let scene = load(
        "la lamp 1 2 3 .5 .5 .5 la other 4 5 6
         k lamp { transl 4 -1 0 -1 0 0 0 0  0 0 0 0 0 0 0  1 0 1 0 0 0 0  2 0 2 0 0 0 0
                  rot 4 0 0 0 1 90 0 0 0  1 0 0 1 90 0 0 0  2 0 0 1 90 0 0 0  3 0 0 1 90 0 0 0 }
         k camera { rot 4 -1 0 1 0 -90 0 0 0  0 0 1 0 0 0 0 0  1 0 1 0 90 0 0 0  2 0 1 0 180 0 0 0 }
         a 0 1 3",
    );
    let frame = at(&scene, 1);
    near(frame.lights[0].position, [1.0, 2.5, 3.0]);
    near(frame.lights[1].position, [4.0, 5.0, 6.0]);
    assert_eq!(frame.lights[1].color, Vec3::ONE);
    // No translation: the eye of `v`.
    near(frame.camera.eye.as_vec3(), [0.0, 0.0, 5.0]);
    near(frame.camera.forward.as_vec3(), [-(0.5_f32.sqrt()), 0.0, -(0.5_f32.sqrt())]);
    near(at(&scene, 2).camera.forward.as_vec3(), Vec3::NEG_X);
    let scene = load("k camera { transl 4 0 1 2 3 0 0 0  1 1 2 3 0 0 0  2 1 2 3 0 0 0  3 1 2 3 0 0 0 }");
    near(at(&scene, 0).camera.eye.as_vec3(), [1.0, 2.0, 3.0]);
    near(at(&scene, 0).camera.forward.as_vec3(), Vec3::NEG_Z);
}

#[test]
fn motion_without_bounds_is_refused() {
    let far = |x: &str| format!("k a {{ transl 4 0 0 0 0 0 0 0  1 0 0 0 0 0 0  2 {x} 0 0 0 0 0  3 0 0 0 0 0 0 }}");
    let text = |x: &str| format!("x a {{ {TRIANGLE} }} {}", far(x));
    assert_eq!(load(&text("1e8")).dynamic_count, 1);
    assert!(error(&text("1e9")).contains("from the origin: at most 1e9 is allowed"));
    assert!(error(&far("1e9").replace("k a", "la a 0 0 0 k a")).contains("at most 1e9"));
    assert!(error(&far("1e9").replace("k a", "k camera")).contains("at most 1e9"));
    let deep = format!("{}{TRIANGLE}{}", "x none { xs 1e30 1 1 0 0 1 0 0 0 0 {".repeat(20), "} }".repeat(20));
    assert!(error(&deep.replace("1e30", "1e9")).contains("at most 1e9"));
    assert!(error(&deep).contains("a number from -1e9 to 1e9, should be here"));
    assert!(error("tpa 1 0 1e9 1e9 0 0 0 1 0 0 0 0 0 1 0 1 0 0 0 1").contains("at most 1e9"));
}
