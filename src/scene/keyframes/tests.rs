//! Tracks compared with closed forms.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;

use super::stretch::Place;
use super::*;

fn key<V>(time: f64, value: V) -> Key<V> {
    Key { time, value, tcb: Tcb::default() }
}

fn near(a: DVec3, b: DVec3) {
    assert!(a.distance(b) < 1e-12, "{a} is not {b}");
}

#[test]
fn uniform_motion_along_a_line_stays_uniform_at_unequal_times() {
    let line = |time: f64| DVec3::new(1.0 - time, 2.0 * time, 3.0);
    let track = VectorTrack::new(&[-1.0, 0.0, 0.5, 3.0, 3.5, 7.0].map(|time| key(time, line(time)))).unwrap();
    for step in 0..=35 {
        let time = f64::from(step) * 0.1;
        near(track.at(time), line(time));
    }
    near(track.at(-0.5), line(0.0));
    near(track.at(9.0), line(3.5));
}

#[test]
fn tension_of_one_stops_at_keys() {
    // Tangents vanish: the cubic is smoothstep, 3u^2 - 2u^3.
    let tcb = Tcb { tension: 1.0, ..Tcb::default() };
    let keys = [0.0, 1.0, 2.0, 3.0].map(|time| Key { time, value: DVec3::X * time, tcb });
    let track = VectorTrack::new(&keys).unwrap();
    for u in [0.0, 0.25, 0.5, 0.75, 1.0] {
        near(track.at(1.0 + u), DVec3::X * (1.0 + u * u * (3.0 - 2.0 * u)));
    }
}

#[test]
fn continuity_and_bias_weigh_the_neighbours() {
    // Values 0, 0, 1, 1: along = 1 and the other differences 0, so the tangents are the weights of `along`:
    // out = (1-C)(1-B)/2, in = (1-C)(1+B)/2, and P(1/2) = 1/2 + (out - in)/8 = 1/2 - (1-C)B/8.
    for (continuity, bias) in [(0.0, 0.5), (0.5, 1.0), (-1.0, -0.5), (1.0, 0.3)] {
        let tcb = Tcb { tension: 0.0, continuity, bias };
        let keys = [0.0, 0.0, 1.0, 1.0].iter().enumerate();
        let keys: Vec<_> = keys.map(|(time, &x)| Key { time: time as f64, value: DVec3::X * x, tcb }).collect();
        let track = VectorTrack::new(&keys).unwrap();
        near(track.at(1.5), DVec3::X * (0.5 - (1.0 - continuity) * bias / 8.0));
    }
    // The weights of the neighbours: only the difference before, or only the one after, is not 0.
    let tcb = Tcb { tension: 0.5, continuity: 0.5, bias: 0.25 };
    let at = |values: [f64; 4]| {
        let mut time = -1.0;
        let keys = values.map(|x| {
            time += 1.0;
            Key { time, value: DVec3::X * x, tcb }
        });
        VectorTrack::new(&keys).unwrap().at(1.5).x
    };
    // P(1/2) = out/8 with out = (1-T)(1+C)(1+B)/2, and -in/8 with in = (1-T)(1+C)(1-B)/2.
    assert!((at([-1.0, 0.0, 0.0, 0.0]) - 0.5 * 1.5 * 1.25 / 16.0).abs() < 1e-15);
    assert!((at([0.0, 0.0, 0.0, 1.0]) + 0.5 * 1.5 * 0.75 / 16.0).abs() < 1e-15);
}

#[test]
fn keys_at_one_time_make_a_jump() {
    let times = [0.0, 1.0, 2.0, 2.0, 3.0, 4.0];
    let track = VectorTrack::new(&times.map(|t| key(t, DVec3::ZERO))).unwrap();
    near(track.at(2.0), DVec3::ZERO);
    let mut keys: Vec<_> = times.map(|t| key(t, DVec3::ZERO)).into();
    for (index, key) in keys.iter_mut().enumerate() {
        key.value = DVec3::X * if index < 3 { 0.0 } else { 5.0 };
    }
    let track = VectorTrack::new(&keys).unwrap();
    near(track.at(2.0), DVec3::X * 5.0);
    assert!(track.at(2.0 - 1e-9).x.abs() < 1e-6);
    // Doubled times at both ends, as in most tracks of the BART robot.
    let keys = [0.0, 0.0, 1.0, 2.0, 2.0].map(|t| key(t, DVec3::X * t));
    near(VectorTrack::new(&keys).unwrap().at(1.0), DVec3::X);
    // All at one time.
    let keys = [1.0; 4].map(|t| key(t, DVec3::X));
    near(VectorTrack::new(&keys).unwrap().at(1.0), DVec3::X);
}

#[test]
fn a_key_that_goes_back_in_time_is_passed_over() {
    // As `gun_rot1` of the BART robot: 48 is followed by 42.
    let times = [30.0, 34.0, 40.0, 48.0, 42.0, 50.0, 51.0];
    let mut index = 0.0;
    let track = VectorTrack::new(&times.map(|time| {
        index += 1.0;
        key(time, DVec3::X * index)
    }))
    .unwrap();
    near(track.at(40.0), DVec3::X * 3.0);
    // At 48 the stretch 42..50 takes over, three quarters of the way through.
    let Place::On(_, u) = track.cubics.at(48.0) else { panic!("48 is inside") };
    assert_eq!(u, 0.75);
    let Place::On(_, u) = track.cubics.at(44.0) else { panic!("44 is inside") };
    assert_eq!(u, 0.5);
}

#[test]
fn bad_keys_are_refused() {
    assert_eq!(VectorTrack::new(&[key(0.0, DVec3::X); 3]), Err(TrackError::TooFew(3)));
    assert_eq!(RotationTrack::new(&[]), Err(TrackError::TooFew(0)));
    let times = |times: [f64; 4]| VectorTrack::new(&times.map(|t| key(t, DVec3::X * t)));
    assert_eq!(times([0.0, 1.0, f64::NAN, 3.0]), Err(TrackError::NotFinite(2)));
    // The keys around the second are at one time: its tangent is infinite.
    assert_eq!(times([2.0, 1.0, 2.0, 3.0]), Err(TrackError::NotFinite(1)));
    let mut keys = [0.0, 1.0, 2.0, 3.0].map(|t| key(t, DVec3::X));
    keys[3].value.y = f64::INFINITY;
    assert_eq!(VectorTrack::new(&keys), Err(TrackError::NotFinite(1)));
}

fn close(a: DMat3, b: DMat3) {
    assert!(a.abs_diff_eq(b, 1e-9), "{a} is not {b}");
}

#[test]
fn uniform_rotation_about_an_axis_stays_uniform_at_unequal_times() {
    let axis = DVec3::new(1.0, 2.0, -2.0) / 3.0;
    let times = [-1.0, 0.0, 0.5, 1.5, 2.5, 3.0];
    let track = RotationTrack::new(&times.map(|t| key(t, DQuat::from_axis_angle(axis, t)))).unwrap();
    for step in 0..=25 {
        let time = f64::from(step) * 0.1;
        close(track.at(time), DMat3::from_axis_angle(axis, time));
    }
    close(track.at(-7.0), DMat3::IDENTITY);
    close(track.at(7.0), DMat3::from_axis_angle(axis, 2.5));
}

#[test]
fn rotations_take_the_shorter_way() {
    // Half angles 160 and -160 degrees: the quaternions are on opposite sides, the rotations 80 degrees apart.
    let turn = |degrees: f64| DQuat::from_axis_angle(DVec3::Z, degrees.to_radians());
    let track = RotationTrack::new(&[240.0, 320.0, -320.0, -240.0].map(|d| {
        let time = [240.0, 320.0, -320.0, -240.0].iter().position(|x| *x == d).unwrap_or(0);
        key(time as f64, turn(d))
    }))
    .unwrap();
    close(track.at(1.5), DMat3::IDENTITY);
}

#[test]
fn quaternions_that_are_too_long_stay_rotations() {
    // The longest axis of the BART robot is 1.077 units; |w| passes 1 in between.
    let keys = [0.0, 1.0, 2.0, 3.0].map(|t| {
        let half: f64 = (10.0 - t) * 1e-3;
        let v = DVec3::Y * 1.077 * half.sin();
        key(t, DQuat::from_xyzw(v.x, v.y, v.z, 1.00007 * half.cos()))
    });
    let track = RotationTrack::new(&keys).unwrap();
    for step in 0..=20 {
        let m = track.at(1.0 + 0.05 * f64::from(step));
        assert!((m * m.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
    }
    // No axis: no rotation.
    let track = RotationTrack::new(&[0.0, 1.0, 2.0, 3.0].map(|t| key(t, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.5))));
    assert_eq!(track.unwrap().at(1.5), DMat3::IDENTITY);
}

#[test]
fn a_motion_scales_then_rotates_then_translates() {
    let hold = |value| VectorTrack::new(&[0.0, 1.0, 2.0, 3.0].map(|t| key(t, value))).ok();
    let quarter = DQuat::from_axis_angle(DVec3::Z, FRAC_PI_2);
    let mut motion = Motion {
        translation: hold(DVec3::new(10.0, 0.0, 0.0)),
        rotation: RotationTrack::new(&[0.0, 1.0, 2.0, 3.0].map(|t| key(t, quarter))).ok(),
        scale: hold(DVec3::new(2.0, 3.0, 4.0)),
        visibility: None,
    };
    near(motion.transform(1.5).transform_point3(DVec3::new(1.0, 1.0, 1.0)), DVec3::new(7.0, 2.0, 4.0));
    assert!((motion.reach(1.0) - 14.0).abs() < 1e-12);
    assert!(motion.visible(0.0));
    motion.visibility = Some(VisibilityTrack { keys: vec![(0.5, false), (2.0, true)] });
    let seen = [0.4, 0.5, 1.9, 2.0, 99.0].map(|time| motion.visible(time));
    assert_eq!(seen, [true, false, false, true, true]);
    assert_eq!(Motion::default().transform(PI), DAffine3::IDENTITY);
}

proptest! {
    #[test]
    fn tracks_pass_their_keys_and_keep_their_bounds(
        steps in prop::collection::vec((0.01..2.0f64, -9.0..9.0f64, -9.0..9.0f64, -1.0..1.0f64), 4..9),
    ) {
        let mut time = 0.0;
        let keys: Vec<_> = steps.iter().map(|&(step, x, y, t)| {
            time += step;
            Key { time, value: DVec3::new(x, y, x * y), tcb: Tcb { tension: t, continuity: -t, bias: t * t } }
        }).collect();
        let track = VectorTrack::new(&keys).unwrap();
        for key in &keys[1..keys.len() - 1] {
            prop_assert!(track.at(key.time).distance(key.value) < 1e-9);
        }
        for step in 0..100 {
            let value = track.at(time * f64::from(step) / 100.0);
            prop_assert!(value.abs().cmple(track.bound() + 1e-9).all());
        }
        let turns: Vec<_> = keys.iter().map(|k| Key {
            time: k.time, value: DQuat::from_rotation_y(k.value.x) * DQuat::from_rotation_x(k.value.y), tcb: k.tcb,
        }).collect();
        let track = RotationTrack::new(&turns).unwrap();
        for key in &turns[1..turns.len() - 1] {
            prop_assert!(track.at(key.time).abs_diff_eq(DMat3::from_quat(key.value), 1e-5));
        }
    }

    #[test]
    fn any_numbers_give_finite_values_or_an_error(
        numbers in prop::collection::vec((-3i32..3, any::<f64>(), any::<f64>(), any::<f64>()), 0..8), at in any::<f64>(),
    ) {
        let keys: Vec<_> = numbers.iter().map(|&(time, x, y, tension)| Key {
            time: f64::from(time), value: DVec3::new(x, y, 0.0), tcb: Tcb { tension, ..Tcb::default() },
        }).collect();
        let turns: Vec<_> = keys.iter().map(|k| Key {
            time: k.time, value: DQuat::from_xyzw(k.value.x, k.value.y, 0.0, 1.0), tcb: k.tcb,
        }).collect();
        for time in [at, -1.5, 0.0, 0.5, f64::NAN] {
            if let Ok(track) = RotationTrack::new(&turns) {
                prop_assert!(track.at(time).is_finite());
            }
            let _ = VectorTrack::new(&keys).map(|track| track.at(time));
        }
    }
}
