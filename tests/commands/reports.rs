//! Commands about reports.

use super::common::Desk;
use super::fits;

#[test]
fn a_replay_writes_its_numbers_in_long_form() {
    let desk = Desk::with_experiment();
    desk.prints(&["trace", "tiny.ron", "-o", "s.rays"]);
    let told = desk.prints(&["replay", "s.rays", "--machine", "small,desktop", "--out", "numbers"]);
    assert!(told.ends_with("results: numbers/results.csv\n"), "{told}");
    let results = std::fs::read_to_string(desk.path("numbers/results.csv")).unwrap();
    assert!(results.contains(",total,,Off,desktop,Event,,,cycles,"), "{results}");
    assert!(desk.path("numbers/results.dictionary.csv").exists());
    let explained = desk.prints(&["explain", "bytes.dram.node", "--report", "numbers"]);
    assert_eq!(explained.matches(".bytes.dram.node").count(), 2, "{explained}");
}

#[test]
fn cases_under_stress_are_chosen_by_name() {
    let desk = Desk::new();
    let told = desk.prints(&["stress", "--case", "C8,c1", "--out", "stress"]);
    assert!(told.contains("0 wrong in 2 cases"), "{told}");
    let message = desk.refuses(&["stress", "--case", "Sliver", "--out", "other"]);
    assert!(message.contains("there is no case `Sliver`; did you mean `Slivers`"), "{message}");
}

#[test]
fn two_reports_are_compared() {
    let desk = Desk::with_experiment();
    desk.prints(&["run", "tiny.ron", "--out", "a"]);
    desk.prints(&["run", "tiny.ron", "--out", "b", "--resolution", "24x24"]);
    let same = desk.prints(&["diff", "a", "a"]);
    assert!(same.contains("no field of the configuration and 0 of "), "{same}");
    let told = desk.prints(&["diff", "a", "b"]);
    assert!(fits(&told, 80), "{told}");
    for part in ["experiment.resolution.height", "ms/frame", "A: a, B: b", "2 fields of the configuration and "] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(desk.prints(&["diff", "a", "b", "--all"]).lines().count() > told.lines().count());
    assert!(desk.refuses(&["diff", "a", "none"]).contains("none/summary.json"));
}

#[test]
fn an_inspection_fits_a_terminal() {
    let desk = Desk::new();
    let told = desk.prints(&["inspect", concat!(env!("CARGO_MANIFEST_DIR"), "/traces/quickstart.rays")]);
    assert!(fits(&told, 80), "{told}");
    insta::assert_snapshot!(told, @"");
}
