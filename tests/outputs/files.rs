//! Files that options name.

use std::fs;

use super::common::{Desk, error_text};

/// A folder with the stream `x.rays`.
fn desk() -> Desk {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "x.rays", "--frames", "0..1"]);
    desk
}

/// Runs a command, which must refuse and leave everything as it was; gives its message.
fn refused(desk: &Desk, args: &[&str]) -> String {
    let before = desk.contents();
    let output = desk.program(args).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {}", error_text(&output));
    assert!(desk.contents() == before, "{args:?}: files were changed");
    error_text(&output)
}

#[test]
fn an_output_is_no_input_whatever_names_it() {
    let desk = desk();
    fs::hard_link(desk.path("x.rays"), desk.path("hard.rays")).unwrap();
    std::os::unix::fs::symlink("small.ron", desk.path("soft.ron")).unwrap();
    let trace = |output| ["trace", "tiny.ron", "--frames", "0..1", "-o", output];
    for output in ["tiny.ron", "./scene.ron", "floor.obj", "kite.obj", "small.ron", "lpddr4_3200.ron"] {
        let message = refused(&desk, &trace(output));
        assert!(message.contains(&format!("`-o {output}` would overwrite it")), "{message}");
    }
    for option in ["--json", "--dram-trace", "--dram-commands", "--line-trace"] {
        for output in ["x.rays", "hard.rays", "small.ron", "soft.ron", "lpddr4_3200.ron"] {
            let message = refused(&desk, &["replay", "x.rays", "--machine", "small.ron", option, output]);
            assert!(message.contains(&format!("`{option} {output}` would overwrite it")), "{message}");
        }
    }
}

#[test]
fn two_outputs_are_two_files() {
    let desk = desk();
    desk.put("a", "");
    std::os::unix::fs::symlink("a", desk.path("b")).unwrap();
    let replay = ["replay", "x.rays", "--machine", "small.ron", "--json", "a", "--line-trace"];
    for other in ["a", "./a", "b"] {
        let message = refused(&desk, &[&replay[..], &[other]].concat());
        assert!(message.contains("are the same file: each output needs its own"), "{message}");
    }
    let thrown_away = ["--json", "/dev/null", "--dram-trace", "/dev/null", "--line-trace", "/dev/null"];
    desk.succeed(&[&replay[..4], &thrown_away].concat());
}

#[test]
fn links_are_followed_and_pipes_and_standard_output_written_to() {
    let desk = desk();
    let replay = ["replay", "x.rays", "--machine", "small.ron"];
    desk.succeed(&[&replay[..], &["--json", "plain.json", "--dram-trace", "plain.trace"]].concat());
    let [json, requests] = ["plain.json", "plain.trace"].map(|file| fs::read(desk.path(file)).unwrap());

    desk.put("real.json", "{}");
    std::os::unix::fs::symlink("real.json", desk.path("link.json")).unwrap();
    desk.succeed(&[&replay[..], &["--json", "link.json"]].concat());
    assert!(desk.path("link.json").is_symlink());
    assert!(fs::read(desk.path("real.json")).unwrap() == json);

    let pipe = desk.path("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read(pipe).unwrap()
    });
    desk.succeed(&[&replay[..], &["--dram-trace", "pipe"]].concat());
    assert!(reader.join().unwrap() == requests);
    assert!(!pipe.is_file());

    // Nothing is beside the figures.
    let output = desk.program(&[&replay[..], &["--json", "-"]].concat()).output().unwrap();
    assert!(output.status.success() && output.stdout == json);
    assert_eq!(error_text(&output), "");
    let stream = desk.program(&["trace", "tiny.ron", "--frames", "0..1", "-o", "-"]).output().unwrap().stdout;
    assert!(stream == fs::read(desk.path("x.rays")).unwrap());
    // Standard output by another name: the table goes to standard error.
    let output = desk.program(&[&replay[..], &["--json", "/dev/stdout"]].concat()).output().unwrap();
    assert!(output.status.success() && error_text(&output).contains("small"), "{}", error_text(&output));
}

#[test]
fn a_full_device_is_told() {
    let desk = desk();
    for args in [
        &["trace", "tiny.ron", "--frames", "0..1", "-o", "/dev/full"][..],
        &["replay", "x.rays", "--machine", "small.ron", "--json", "/dev/full"],
        &["replay", "x.rays", "--machine", "small.ron", "--line-trace", "/dev/full"],
    ] {
        let message = refused(&desk, args);
        assert!(message.contains("cannot write /dev/full: No space left on device"), "{message}");
    }
}
