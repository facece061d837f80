//! A disk that is full. A limit on the length of files stands for it: it needs no rights, and ends a write the same
//! way.

use std::fs;
use std::process::Stdio;

use super::common::{Desk, error_text};

#[test]
fn a_stream() {
    let desk = Desk::with_experiment();
    let trace = ["trace", "tiny.ron", "-o", "x.rays"];
    insta::assert_snapshot!(desk.refuses(desk.limited(8, &trace)), @"error: cannot write x.rays: File too large (os error 27)");
    // An earlier stream stays as it is.
    desk.succeed(&trace);
    desk.refuses(desk.limited(8, &trace));
}

#[test]
fn a_report() {
    let desk = Desk::with_experiment();
    let run = ["run", "tiny.ron", "--out", "report"];
    insta::assert_snapshot!(desk.refuses(desk.limited(1, &run)), @"error: cannot write report/config.ron: File too large (os error 27)");
    // Room for the numbers, but not for the page.
    insta::assert_snapshot!(desk.refuses(desk.limited(64, &run)), @"error: cannot write report/results.csv: File too large (os error 27)");
    // An earlier report stays as it is.
    desk.succeed(&run);
    desk.refuses(desk.limited(64, &run));
}

#[test]
fn a_page_drawn_again() {
    let desk = Desk::with_experiment();
    desk.succeed(&["run", "tiny.ron", "--out", "report"]);
    insta::assert_snapshot!(desk.refuses(desk.limited(64, &["plot", "report"])), @"error: cannot write report/results.csv: File too large (os error 27)");
}

#[test]
fn measurements_of_a_replay() {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "x.rays", "--frames", "0..1"]);
    let replay = ["replay", "x.rays", "--machine", "small.ron", "--json", "out.json"];
    insta::assert_snapshot!(desk.refuses(desk.limited(1, &replay)), @"error: cannot write out.json: File too large (os error 27)");
    let nowhere = ["replay", "x.rays", "--machine", "small.ron", "--json", "nowhere/out.json"];
    insta::assert_snapshot!(desk.refused(&nowhere), @"error: cannot write nowhere/out.json: there is no folder nowhere");
}

#[test]
fn standard_output() {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "x.rays", "--frames", "0..1"]);
    let inspect = |out: Stdio| {
        let mut program = std::process::Command::new(assert_cmd::cargo::cargo_bin("umbrasim"));
        program.args(["inspect", "x.rays"]).current_dir(desk.path(""));
        program.stdout(out).stderr(Stdio::piped()).spawn().unwrap()
    };
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = inspect(full.into()).wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    insta::assert_snapshot!(error_text(&output), @"error: cannot write to standard output: No space left on device (os error 28)");

    // A reader that wants no more, as in `umbrasim inspect x.rays | head`, is no error.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = inspect(writer.into()).wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{}", error_text(&output));
}
