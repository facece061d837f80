//! Commands about reports.

use super::common::Desk;
use super::fits;

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
