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
    insta::assert_snapshot!(told, @"
    scene       room
    policy      Published
    structure   Bvh2
    resolution  48x48
    lights      4
    triangles   28,308 static, 1,468 dynamic
    input hash  fd921f6e90f550c6
    file        version 3, 894 kB, 4 frames

    frame    rays  shadow  skipped  dynamic   dark  policy    bytes  bytes/ray
                                       only          steps
    ──────────────────────────────────────────────────────────────────────────
    0      10,880   8,576        0        0  5,001  20,314  267,038      24.54
    1      10,878   8,574    4,051    2,972  4,990  13,295  171,820      15.80
    2      10,880   8,576    4,093    2,996  4,995  13,218  169,998      15.62
    3      10,875   8,571    4,094    2,995  4,993  13,215  171,082      15.73

    Rays by the steps of their paths:

    frame  kind      rays  steps/ray      0      1  2-3  4-7   8-15  16-31  32-63
    ─────────────────────────────────────────────────────────────────────────────
    0      primary  2,304      27.58      0      0    0    0      0  1,802    482
    0      shadow   8,576      23.58      0      0    0   11  1,309  6,007  1,209
    1      primary  2,304      27.56      0      0    0    0      0  1,797    486
    1      shadow   8,574       4.97  4,051  2,796  114   21    226  1,069    286
    2      primary  2,304      27.54      0      0    0    0      0  1,794    491
    2      shadow   8,576       4.75  4,093  2,820  115   28    226  1,000    284
    3      primary  2,304      27.57      0      0    0    0      0  1,802    483
    3      shadow   8,571       4.77  4,094  2,824  105   24    229  1,001    282

    frame  kind     64-127  128-255
    ───────────────────────────────
    0      primary      20        0
    0      shadow       40        0
    1      primary      21        0
    1      shadow       11        0
    2      primary      19        0
    2      shadow       10        0
    3      primary      18        1
    3      shadow       12        0
    ");
}
