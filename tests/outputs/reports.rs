//! Reports that are written again and again.

use std::fs::{self, OpenOptions};
use std::process::Stdio;

use super::common::{Desk, EXPERIMENT, error_text};

const RUN: [&str; 6] = ["run", "tiny.ron", "--frames", "0..1", "--out", "rep"];

/// A folder with the stream `x.rays` and the sweep and the comparison of `tiny.ron`.
fn desk() -> Desk {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "x.rays", "--frames", "0..1"]);
    desk.put("sweep.ron", "(experiment: \"tiny.ron\", frames: \"0..1\", vary: {\"clock_mhz\": [500, 600]})");
    let pareto = "(experiments: [(file: \"tiny.ron\", frames: \"0..1\")], machines: [\"small.ron\"], rungs: [Bound])";
    desk.put("pareto.ron", pareto);
    desk.succeed(&["run", "tiny.ron", "--frames", "0..2", "--out", "other"]);
    desk
}

/// Commands that write a report into a folder, which is to be named behind.
const REPORTS: [&[&str]; 8] = [
    &["run", "tiny.ron", "--frames", "0..1", "--out"],
    &["validate", "tiny.ron", "--frames", "0..1", "--out"],
    &["profile", "x.rays", "--machine", "small.ron", "--out"],
    &["sweep", "sweep.ron", "--out"],
    &["pareto", "pareto.ron", "--out"],
    &["chart", "base", "--out"],
    &["diff", "base", "other", "--out"],
    &["extrapolate", "x.rays", "--machine", "small.ron", "--cores", "8", "--fidelity", "Profile", "--out"],
];

/// A file in a report that is as large for every report of a command.
fn names(desk: &Desk, folder: &str) -> Vec<String> {
    let mut names: Vec<String> = desk
        .contents()
        .into_iter()
        .filter_map(|(path, _)| path.strip_prefix(desk.path(folder)).ok().map(|path| path.display().to_string()))
        .collect();
    names.sort();
    names
}

#[test]
fn every_command_runs_again_over_what_it_wrote_and_foreign_files_stay() {
    let desk = desk();
    desk.succeed(&["run", "tiny.ron", "--frames", "0..1", "--out", "base"]);
    for command in REPORTS {
        let write = |folder| desk.succeed(&[command, &[folder]].concat());
        write("rep");
        let own = names(&desk, "rep");
        desk.put("rep/notes.txt", "mine");
        desk.put("rep/plots/mine.svg", "mine");
        write("rep/child");
        let child = names(&desk, "rep/child");
        write("rep");
        assert_eq!(fs::read_to_string(desk.path("rep/notes.txt")).unwrap(), "mine", "{command:?}");
        assert_eq!(fs::read_to_string(desk.path("rep/plots/mine.svg")).unwrap(), "mine", "{command:?}");
        assert_eq!(names(&desk, "rep/child"), child, "{command:?}");
        let foreign =
            |name: &&String| name.as_str() == "notes.txt" || name.contains("mine") || name.starts_with("child");
        let all = names(&desk, "rep");
        assert_eq!(all.iter().filter(|name| !foreign(name)).cloned().collect::<Vec<_>>(), own, "{command:?}");
        fs::remove_dir_all(desk.path("rep")).unwrap();
    }
    let plotted = names(&desk, "base");
    (0..2).for_each(|_| drop(desk.succeed(&["plot", "base"])));
    assert_eq!(names(&desk, "base"), plotted);
}

#[test]
fn a_link_to_a_report_is_followed() {
    let desk = desk();
    fs::create_dir(desk.path("disk")).unwrap();
    std::os::unix::fs::symlink("disk", desk.path("rep")).unwrap();
    (0..2).for_each(|_| drop(desk.succeed(&RUN)));
    assert!(desk.path("rep").is_symlink() && desk.path("disk/index.html").is_file());
}

#[test]
fn a_place_that_takes_no_report_is_refused_before_the_work() {
    let desk = desk();
    desk.succeed(&["run", "tiny.ron", "--frames", "0..1", "--out", "base"]);
    for command in REPORTS {
        for (place, told) in
            [("/proc/nowhere", "cannot write /proc/nowhere"), ("tiny.ron/x", "is not an umbrasim report")]
        {
            let before = desk.contents();
            let output = desk.program(&[command, &[place]].concat()).output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{command:?}: {}", error_text(&output));
            assert!(output.stdout.is_empty() && error_text(&output).contains(told), "{}", error_text(&output));
            assert!(desk.contents() == before);
        }
    }
    // A report would be read and written.
    desk.succeed(&["run", "tiny.ron", "--frames", "0..2", "--out", "other"]);
    let before = desk.contents();
    for command in [
        &["chart", "base", "--out", "base"][..],
        &["diff", "base", "other", "--out", "base"],
        &["diff", "base", "other", "--out", "other"],
    ] {
        let output = desk.program(command).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{command:?}");
        assert!(error_text(&output).contains("would overwrite it"), "{}", error_text(&output));
        assert!(desk.contents() == before, "{command:?}");
    }
}

#[test]
fn a_full_or_closed_standard_output_loses_nothing() {
    let desk = desk();
    desk.succeed(&["run", "tiny.ron", "--frames", "0..1", "--out", "base"]);
    let spawn = |args: &[&str], output: Stdio| {
        let mut program = std::process::Command::new(assert_cmd::cargo::cargo_bin("umbrasim"));
        program.args(args).current_dir(desk.path("")).stdout(output).stderr(Stdio::piped());
        program.spawn().unwrap().wait_with_output().unwrap()
    };
    for (number, command) in REPORTS.into_iter().enumerate() {
        let folder = format!("rep{number}");
        let args = [command, &[folder.as_str()]].concat();
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = spawn(&args, full.into());
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", error_text(&output));
        assert!(error_text(&output).contains("cannot write to standard output"), "{}", error_text(&output));
        assert!(desk.path(&folder).join("summary.json").is_file(), "{args:?}");
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = spawn(&args, writer.into());
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", error_text(&output));
    }
}

/// What is said on standard error is lost where that is full, and nothing else.
#[test]
fn a_full_standard_error_loses_nothing() {
    let desk = desk();
    let code = |args: &[&str]| {
        let mut program = std::process::Command::new(assert_cmd::cargo::cargo_bin("umbrasim"));
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        program.args(args).current_dir(desk.path("")).stderr(full).stdout(Stdio::null()).status().unwrap().code()
    };
    assert_eq!(code(&["run", "tiny.ron", "--frames", "0..1", "--out", "r"]), Some(0));
    assert!(desk.path("r/summary.json").is_file());
    assert_eq!(code(&["inspect", "absent.rays"]), Some(2));
}

#[test]
fn names_that_would_share_a_file_get_one_each() {
    let desk = desk();
    let machine = super::common::machine();
    desk.put_changed("m1.ron", &machine, "name: \"small\"", "name: \"x y\"");
    desk.put_changed("m2.ron", &machine, "name: \"small\"", "name: \"X_Y\"");
    let policies = "\"太\": Published(), \"郎\": Published(), \"off\": Published(), \"Off\": Off,";
    let experiment =
        EXPERIMENT.replace("\"Off\": Off,", policies).replace("[\"small.ron\"]", "[\"m1.ron\", \"m2.ron\"]");
    desk.put("names.ron", &experiment);
    desk.succeed(&["run", "names.ron", "--frames", "0..1", "--out", "rep"]);
    let all = names(&desk, "rep");
    let count = |part: &str| all.iter().filter(|name| name.contains(part)).count();
    let plots = all.iter().filter(|name| name.contains("utilization") && name.ends_with(".svg")).count();
    assert_eq!((count("-render.png"), plots), (5, 2), "{all:?}");
    let folded: std::collections::BTreeSet<String> = all.iter().map(|name| name.to_lowercase()).collect();
    assert_eq!(folded.len(), all.len(), "{all:?}");
}

#[test]
fn a_run_without_shadow_rays_says_so() {
    let desk = desk();
    // The light of the sky only: the camera looks away from everything.
    let away = super::common::SCENE.replace("look: Along(0, -0.4, -1)", "look: Along(0, 0.4, 1)");
    desk.put("scene.ron", &away);
    desk.succeed(&RUN);
    let page = fs::read_to_string(desk.path("rep/index.html")).unwrap();
    assert!(page.contains("no ray of the run asked for a shadow ray"), "{page}");
}
