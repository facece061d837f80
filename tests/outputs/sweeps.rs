//! Kept streams and points of sweeps.

use std::fs;
use std::path::PathBuf;

use super::common::{Desk, KITE, error_text};

/// A scene of one file, with a light, a camera, a material and a ball that moves.
const AFF: &str = "a 0 20 30\nv from 0 2 6 at 0 1 0 up 0 1 0 angle 50 hither 0.01 resolution 16 16\nb 0.2 0.3 0.4\n\
    l 1 4 2 0.9 0.9 0.9\nfm 0.1 0.1 0.1 0.5 0.6 0.2 0 0 0 20 0 1\np 4 -4 0 -4 4 0 -4 4 0 4 -4 0 4\ns 0 1 0 0.7\n\
    x ball { s 0 0 0 0.4 }\nk ball { transl 4 -1 1 1 0 0 0 0 0 1 1 0 0 0 0 10 1 1 1 0 0 0 21 2 0 0 0 0 0 }\n";

fn desk() -> Desk {
    let desk = Desk::with_experiment();
    desk.put("sweep.ron", "(experiment: \"tiny.ron\", frames: \"0..2\", vary: {\"clock_mhz\": [400, 600]})");
    let other = "(experiment: \"tiny.ron\", frames: \"0..2\", resolution: (width: 8, height: 8), vary: {\"clock_mhz\": [400, 600]})";
    desk.put("other.ron", other);
    desk
}

fn sweep(desk: &Desk, config: &str, folder: &str) -> (Vec<u8>, String) {
    let output = desk.program(&["sweep", config, "--out", folder]).output().unwrap();
    assert!(output.status.success(), "{}", error_text(&output));
    (fs::read(desk.path(folder).join("sweep.csv")).unwrap(), error_text(&output))
}

/// The files of a part of a sweep's folder.
fn kept(desk: &Desk, part: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(desk.path("s").join(part)).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn a_sweep_over_changed_files_is_as_a_new_one() {
    let desk = desk();
    desk.put("aff.ron", "Aff(\"scene.aff\")");
    desk.put("scene.aff", AFF);
    let experiment = super::common::EXPERIMENT;
    desk.put_changed("affine.ron", experiment, "scene: \"scene.ron\"", "scene: \"aff.ron\"");
    desk.put("affine_sweep.ron", "(experiment: \"affine.ron\", frames: \"0..1\", vary: {\"clock_mhz\": [400]})");
    let larger = KITE.replace("v 0 0 0.8", "v 0 0 2.8");
    let with = |from: &str, to: &str| AFF.replace(from, to);
    let changes = [
        ("sweep.ron", "kite.obj", larger),
        ("sweep.ron", "floor.obj", super::common::FLOOR.replace("v 3 0 3", "v 2 0 2")),
        ("affine_sweep.ron", "scene.aff", with("l 1 4 2", "l -2 1.5 1")),
        ("affine_sweep.ron", "scene.aff", with("from 0 2 6", "from 0 1 3")),
        ("affine_sweep.ron", "scene.aff", with("s 0 0 0 0.4", "s 0 0 0 0.9")),
    ];
    for (number, (config, file, text)) in changes.into_iter().enumerate() {
        let before = fs::read(desk.path(file)).unwrap();
        let (was, _) = sweep(&desk, config, "s");
        desk.put(file, &text);
        let (resumed, told) = sweep(&desk, config, "s");
        assert!(told.contains("streams of other inputs or builds stay there, unread:"), "{told}");
        let (fresh, _) = sweep(&desk, config, &format!("fresh{number}"));
        assert!(resumed == fresh, "{file}: stale");
        assert!(resumed != was, "change {number} of {file} changes nothing");
        desk.put(file, &before);
        assert!(sweep(&desk, config, "s").0 == was);
    }
}

/// What a link in a sweep's folder leads to is the user's.
#[cfg(unix)]
#[test]
fn links_in_a_sweeps_folder_are_replaced_and_not_followed() {
    let desk = desk();
    let (table, _) = sweep(&desk, "sweep.ron", "s");
    desk.put("mine.txt", "mine");
    for part in ["points", "streams"] {
        let file = kept(&desk, part).remove(0);
        // Where points lack, streams are looked at.
        kept(&desk, "points").iter().for_each(|point| fs::remove_file(point).unwrap());
        _ = fs::remove_file(&file);
        std::os::unix::fs::symlink(desk.path("mine.txt"), &file).unwrap();
        let (again, told) = sweep(&desk, "sweep.ron", "s");
        assert!(again == table && told.contains("again"), "{told}");
        assert!(!file.is_symlink(), "{}", file.display());
        assert_eq!(fs::read(desk.path("mine.txt")).unwrap(), b"mine");
    }
}

#[test]
fn what_is_damaged_or_foreign_is_made_again_and_told() {
    let desk = desk();
    let (table, told) = sweep(&desk, "sweep.ron", "s");
    assert!(!told.contains("again"), "{told}");
    let (points, streams) = (kept(&desk, "points"), kept(&desk, "streams"));
    assert_eq!((points.len(), streams.len()), (9, 2));

    // A digit in every point.
    for point in &points {
        let text = fs::read_to_string(point).unwrap();
        fs::write(point, text.replacen("\"cycles\": ", "\"cycles\": 9", 1)).unwrap();
    }
    let (healed, told) = sweep(&desk, "sweep.ron", "s");
    assert!(healed == table && told.matches("the point is made again").count() == 9, "{told}");

    // Each point is another's.
    let texts: Vec<Vec<u8>> = points.iter().map(|point| fs::read(point).unwrap()).collect();
    points.iter().zip(texts.iter().cycle().skip(1)).for_each(|(point, text)| fs::write(point, text).unwrap());
    assert!(sweep(&desk, "sweep.ron", "s").0 == table);

    // A byte in the middle of a stream, and streams that are each other's, cut off, or nothing at all.
    let good: Vec<Vec<u8>> = streams.iter().map(|stream| fs::read(stream).unwrap()).collect();
    let mut flipped = good[1].clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    for bad in [&flipped[..], &good[0], &good[1][..middle], b""] {
        kept(&desk, "points").iter().for_each(|point| fs::remove_file(point).unwrap());
        fs::write(&streams[1], bad).unwrap();
        let (healed, told) = sweep(&desk, "sweep.ron", "s");
        assert!(healed == table && told.contains("the stream is recorded again"), "{told}");
        assert!(fs::read(&streams[1]).unwrap() == good[1]);
    }
}

#[test]
fn two_sweeps_at_once_poison_nothing() {
    let desk = desk();
    let [(one, _), (other, _)] = [("sweep.ron", "one"), ("other.ron", "other")].map(|(of, to)| sweep(&desk, of, to));
    for round in 0..6 {
        let mut first = desk.spawn(&["sweep", "sweep.ron", "--out", "s"]);
        std::thread::sleep(std::time::Duration::from_millis(10 * round));
        let second = desk.program(&["sweep", "other.ron", "--out", "s"]).output().unwrap();
        let told = error_text(&second);
        let name = format!("s is being written by process {} on ", first.id());
        let refused = second.status.code() == Some(2) && told.contains(&name);
        assert!(second.status.success() || refused, "{told}");
        first.wait().unwrap();
        assert!(sweep(&desk, "sweep.ron", "s").0 == one && sweep(&desk, "other.ron", "s").0 == other);
        fs::remove_dir_all(desk.path("s")).unwrap();
    }
}

#[test]
fn too_many_machines_are_refused_before_they_are_made() {
    let desk = desk();
    let values = (1..=100).map(|value| value.to_string()).collect::<Vec<_>>().join(", ");
    let fields = ["clock_mhz", "dispatcher.rays", "list.lists", "traversal.rays", "intersection.tests"];
    let vary = fields.map(|field| format!("\"{field}\": [{values}]")).join(", ");
    desk.put("many.ron", &format!("(experiment: \"tiny.ron\", vary: {{{vary}}}, points: All)"));
    let output = desk.program(&["sweep", "many.ron", "--out", "s"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = error_text(&output);
    assert!(told.contains("`vary` makes 10000000000 machines: up to 100000 are allowed"), "{told}");
}
