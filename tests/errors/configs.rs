//! Configs and command lines that are wrong.

use super::common::{Desk, EXPERIMENT, SCENE, machine};

/// What a run of the experiment says with one place of it changed.
fn experiment(from: &str, to: &str) -> String {
    let desk = Desk::with_experiment();
    desk.put_changed("tiny.ron", EXPERIMENT, from, to);
    desk.refused(&["run", "tiny.ron", "--out", "report"])
}

/// What a replay says on a machine with one place of its file changed.
fn on_machine(from: &str, to: &str) -> String {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "good.rays", "--frames", "0..1"]);
    desk.put_changed("small.ron", &machine(), from, to);
    desk.refused(&["replay", "good.rays", "--machine", "small.ron"])
}

#[test]
fn a_typo() {
    insta::assert_snapshot!(experiment("resolution", "resolutoin"), @"");
    insta::assert_snapshot!(experiment("Published()", "Publishd()"), @"");
    insta::assert_snapshot!(experiment("Published()", "Published(border: Lft)"), @"");
    insta::assert_snapshot!(experiment("policies: {", "policies: ["), @"");
    insta::assert_snapshot!(on_machine("shading_cycles", "shading_cycle"), @"");
}

#[test]
fn a_value_out_of_range() {
    insta::assert_snapshot!(experiment("width: 16", "width: 0"), @"");
    insta::assert_snapshot!(experiment("\"tiny\"", "\"a/b\""), @"");
    insta::assert_snapshot!(on_machine("clock_mhz: 500", "clock_mhz: 0"), @"");
}

#[test]
fn sizes_that_do_not_fit_together() {
    insta::assert_snapshot!(on_machine("bytes: 16384, ways: 4", "bytes: 16384, ways: 3"), @"");
    insta::assert_snapshot!(on_machine("row_bytes: 2048", "row_bytes: 32"), @"");
    insta::assert_snapshot!(on_machine("mapping: [Column(1), Bank(3)", "mapping: [Column(1), Bank(2)"), @"");
}

#[test]
fn nothing_to_measure_against() {
    insta::assert_snapshot!(experiment("\"Off\": Off,", ""), @"");
}

#[test]
fn frames_beyond_the_scene() {
    let desk = Desk::with_experiment();
    desk.put_changed("scene.ron", SCENE, "frame_count: 1000000", "frame_count: 120");
    insta::assert_snapshot!(desk.refused(&["trace", "tiny.ron", "-o", "x.rays", "--frames", "100..121"]), @"");
}

#[test]
fn a_wrong_command_line() {
    let desk = Desk::with_experiment();
    let first = |args: &[&str]| desk.refused(args).lines().next().unwrap_or_default().to_owned();
    insta::assert_snapshot!(first(&["trace", "tiny.ron", "-o", "x.rays", "--policy", "Publshed"]), @"");
    insta::assert_snapshot!(first(&["run", "tiny.ron", "--frames", "9..3"]), @"");
    insta::assert_snapshot!(first(&["run", "tiny.ron", "--resolution", "512"]), @"");
    insta::assert_snapshot!(first(&["run", "tiny.ron", "--threads", "0"]), @"");
    insta::assert_snapshot!(first(&["run", "absent.ron"]), @"");
}

#[test]
fn an_output_that_is_no_report() {
    let desk = Desk::with_experiment();
    std::fs::create_dir(desk.path("notes")).unwrap();
    desk.put("notes/todo.txt", "water the plants");
    insta::assert_snapshot!(desk.refused(&["run", "tiny.ron", "--out", "notes"]), @"");
    insta::assert_snapshot!(desk.refused(&["run", "tiny.ron", "--out", "notes/todo.txt"]), @"");
    insta::assert_snapshot!(desk.refused(&["plot", "notes"]), @"");
    insta::assert_snapshot!(desk.refused(&["trace", "tiny.ron", "-o", "notes"]), @"");
    insta::assert_snapshot!(desk.refused(&["trace", "tiny.ron", "-o", "nowhere/x.rays"]), @"");
}
