//! Commands that are ended at any moment.

use std::fs;
use std::process::Command;
use std::time::Duration;

use super::common::{Desk, error_text};

/// Names in a folder that a command may only have while it works.
fn temporary(desk: &Desk) -> Vec<String> {
    let names = desk.contents().into_iter().map(|(path, _)| path.display().to_string());
    names.filter(|name| name.contains("/.umbrasim-")).collect()
}

/// A table of readings of the scene.
const PAPER: &str = r#"(
    scenes: [(scene: "scene.ron", published: (
        traversal_saved: (mean: 0.2, max: 0.6), intersection_saved: (mean: 0.2, max: 0.6),
        occlusion_tests_per_pixel: 0.2,
    ))],
    resolution: (width: 8, height: 8), frames: ["0..2"], structures: [Bvh2], depths: [1], shadow_rays: [Always],
    policies: {"returns": Published()},
)"#;

fn signal(pid: u32, signal: &str) {
    assert!(Command::new("kill").args([signal, &pid.to_string()]).status().unwrap().success());
}

#[test]
fn signals_leave_nothing_behind() {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "x.rays", "--frames", "0..400"]);
    let before = desk.contents();
    let commands: [&[&str]; 7] = [
        &["stress", "--out", "rep"],
        &["ladder-map", "--out", "rep"],
        &["validate", "tiny.ron", "--out", "rep", "--frames", "0..100000"],
        &["trace", "tiny.ron", "-o", "y.rays", "--frames", "0..100000"],
        &["run", "tiny.ron", "--out", "rep", "--frames", "0..100000"],
        &["replay", "x.rays", "--machine", "small.ron", "--fidelity", "Cycle", "--json", "y.json"],
        &["profile", "x.rays", "--machine", "small.ron", "--out", "new/profile"],
    ];
    // Under `nohup` a hang-up is ignored, and the program leaves it so.
    let ignored = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = ignored.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    let hears_hangups = ignored.is_none_or(|signals| signals & 1 == 0);
    if !hears_hangups {
        println!("skipped: hang-ups are ignored here, what they do is not tested");
    }
    let names = ["-INT", "-TERM", "-HUP"].into_iter().take(if hears_hangups { 3 } else { 2 });
    for command in commands {
        for name in names.clone() {
            let mut child = desk.spawn(command);
            std::thread::sleep(Duration::from_millis(300));
            for _ in 0..2 {
                if child.try_wait().unwrap().is_none() {
                    signal(child.id(), name);
                }
                std::thread::sleep(Duration::from_millis(50));
            }
            child.wait().unwrap();
            assert_eq!(temporary(&desk), Vec::<String>::new(), "{command:?} {name}");
            for written in ["rep", "new", "y.rays", "y.json"] {
                let _ = fs::remove_dir_all(desk.path(written));
                let _ = fs::remove_file(desk.path(written));
            }
            assert!(desk.contents() == before, "{command:?} {name}");
        }
    }
}

/// One that dies between putting a point into its place and letting go of its lock leaves the lock alone.
#[test]
fn a_dead_lock_goes_although_every_point_is_kept() {
    let desk = Desk::with_experiment();
    desk.put("sweep.ron", "(experiment: \"tiny.ron\", frames: \"0..2\", vary: {\"clock_mhz\": [400]})");
    let command = ["sweep", "sweep.ron", "--out", "swe"];
    desk.succeed(&command);
    for part in ["points", "streams", "shards"] {
        desk.put(&format!("swe/{part}/.umbrasim-dead.json.lock"), "process 1");
    }
    desk.succeed(&command);
    assert_eq!(temporary(&desk), Vec::<String>::new());
}

#[test]
fn a_kill_at_any_moment_leaves_the_old_or_the_new_and_the_next_run_sweeps() {
    let desk = Desk::with_experiment();
    desk.put("sweep.ron", "(experiment: \"tiny.ron\", frames: \"0..2\", vary: {\"clock_mhz\": [400, 600]})");
    let pareto = "(experiments: [(file: \"tiny.ron\", frames: \"0..2\")], machines: [\"small.ron\"], rungs: [Bound])";
    desk.put("pareto.ron", pareto);
    let scenes = "resolution: (width: 8, height: 8), scenes: [(scene: \"scene.ron\", frame: 0)]";
    desk.put(
        "identities.ron",
        &format!("(machine: \"small.ron\", {scenes}, accel: (structure: KdTree), published: [])"),
    );
    desk.put("paper.ron", PAPER);
    desk.succeed(&["trace", "tiny.ron", "-o", "in.rays", "--frames", "0..2"]);
    for folder in ["base", "other"] {
        desk.succeed(&["run", "tiny.ron", "--frames", "0..2", "--out", folder]);
    }
    let exports = ["--line-trace", "x.lines", "--dram-trace", "x.dram", "--dram-commands", "x.commands"];
    let exports = [&["replay", "in.rays", "--machine", "small.ron"][..], &exports].concat();
    let models = ["extrapolate", "in.rays", "--machine", "small.ron", "--cores", "8", "--out", "mod"];
    let commands: [(&[&str], &str); 13] = [
        (&["run", "tiny.ron", "--frames", "0..2", "--out", "rep"], "rep/summary.json"),
        (&["trace", "tiny.ron", "--frames", "0..2", "-o", "x.rays"], "x.rays"),
        (&["replay", "in.rays", "--machine", "small.ron", "--json", "x.json"], "x.json"),
        (&["profile", "in.rays", "--machine", "small.ron", "--out", "pro"], "pro/reuse.csv"),
        (&["sweep", "sweep.ron", "--out", "swe"], "swe/sweep.csv"),
        (&["validate", "tiny.ron", "--frames", "0..2", "--out", "val"], "val/frames.csv"),
        (&["chart", "base", "other", "--out", "cha"], "cha/summary.json"),
        (&["plot", "base"], "base/index.html"),
        (&exports, "x.lines"),
        (&["pareto", "pareto.ron", "--out", "par"], "par/pareto.csv"),
        (&models, "mod/extrapolate.csv"),
        (&["identities", "identities.ron", "--json", "i.json"], "i.json"),
        (&["paper-table", "paper.ron", "--json", "p.json"], "p.json"),
    ];
    // The long suite kills each command at 40 moments.
    let moments = if std::env::var_os("UMBRASIM_LONG").is_some() { 40 } else { 8 };
    for (command, result) in commands {
        let timings = |text: Vec<u8>| {
            // Wall time is in the summary of a run.
            String::from_utf8_lossy(&text).split("\"made\"").next().unwrap().to_owned()
        };
        let read = || fs::read(desk.path(result)).ok().map(timings);
        let begin = std::time::Instant::now();
        desk.succeed(command);
        let took = begin.elapsed();
        let whole = read();
        desk.put("notes.txt", "mine");
        for moment in 0..moments {
            // What is drawn again is an input, too.
            if moment % 2 == 0 && command[0] != "plot" {
                let top = desk.path(result.split('/').next().unwrap());
                let _ = if top.is_dir() { fs::remove_dir_all(top) } else { fs::remove_file(top) };
            } else {
                desk.succeed(command);
            }
            let mut child = desk.spawn(command);
            std::thread::sleep(took * moment / moments);
            child.kill().unwrap();
            child.wait().unwrap();
            let found = read();
            assert!(found.is_none() || found == whole, "{command:?}, moment {moment}: a part was taken for the whole");
            assert!(moment % 2 == 0 || found == whole, "{command:?}, moment {moment}: the earlier result is lost");
        }
        // Two at once: one may be refused, and the result is whole.
        let mut first = desk.spawn(command);
        let second = desk.program(command).output().unwrap();
        assert!(matches!(second.status.code(), Some(0 | 2)), "{}", error_text(&second));
        first.wait().unwrap();
        desk.succeed(command);
        assert_eq!(read(), whole, "{command:?}");
        assert_eq!(temporary(&desk), Vec::<String>::new(), "{command:?}");
    }
}
