//! Configs and command lines that are wrong.

use super::common::{Desk, EXPERIMENT, SCENE, dram_part, machine};

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

/// What a replay says on a machine with one place of its DRAM part's file changed.
fn on_dram(from: &str, to: &str) -> String {
    let desk = Desk::with_experiment();
    desk.succeed(&["trace", "tiny.ron", "-o", "good.rays", "--frames", "0..1"]);
    desk.put_changed("lpddr4_3200.ron", &dram_part(), from, to);
    desk.refused(&["replay", "good.rays", "--machine", "small.ron"])
}

#[test]
fn a_dram_part() {
    insta::assert_snapshot!(on_dram("rrd_s", "rrds"), @r#"
    error: small.ron:49:16: lpddr4_3200.ron:15:29: unknown field `rrds`; did you mean `rrd_s`? Allowed: `cl`, `cwl`, `rcd`, `rp`, `ras`, `rc`, `ccd_s`, `ccd_l`, `rrd_s`, `rrd_l`, `faw`, `rtp`, `wr`, `wtr_s`, `wtr_l`, `turn`, `refi`, `rfc`
        |
     15 |         ccd_s: 8, ccd_l: 8, rrds: 16, rrd_l: 16, faw: 64,
        |                             ^
        |
     49 |         part: "lpddr4_3200.ron",
        |                ^
    "#);
    insta::assert_snapshot!(on_dram("banks: 8", "banks: 7"), @r#"
    error: small.ron:49:16: lpddr4_3200.ron:9:12: 7 is not allowed here: a power of two from 1 to 64 is
       |
     9 |     banks: 7,
       |            ^
        |
     49 |         part: "lpddr4_3200.ron",
        |                ^
    "#);
    insta::assert_snapshot!(on_dram("rfc: 288,", ""), @r#"
    error: small.ron:49:16: lpddr4_3200.ron:19:5: Unexpected missing field named `rfc` in `Timing`
        |
     19 |     ),
        |     ^
        |
     49 |         part: "lpddr4_3200.ron",
        |                ^
    "#);
    insta::assert_snapshot!(on_machine("\"lpddr4_3200.ron\"", "\"lpddr4.ron\""), @r#"
    error: small.ron:49:16: cannot read lpddr4.ron: No such file or directory (os error 2)
        |
     49 |         part: "lpddr4.ron",
        |                ^
    "#);
    insta::assert_snapshot!(on_dram("ras: 68, rc: 102", "ras: 68, rc: 100"), @r#"
    error: small.ron:49:16: lpddr4_3200.ron:14:52: `timing.rc` is 100: at least ras + rp = 102 is allowed
        |
     14 |         cl: 28, cwl: 14, rcd: 29, rp: 34, ras: 68, rc: 100,
        |                                                    ^
        |
     49 |         part: "lpddr4_3200.ron",
        |                ^
    "#);
    insta::assert_snapshot!(on_dram("wtr_s: 16", "wtr_s: 8"), @r#"
    error: small.ron:49:16: lpddr4_3200.ron:16:26: `timing.wtr_s` is 8: without groups, wtr_l = 16 alone is allowed
        |
     16 |         rtp: 12, wr: 29, wtr_s: 8, wtr_l: 16,
        |                          ^
        |
     49 |         part: "lpddr4_3200.ron",
        |                ^
    "#);
    insta::assert_snapshot!(on_dram("refi: 6248", "refi: 900"), @r#"
    error: small.ron:49:16: lpddr4_3200.ron:18:9: `timing.refi` is 900: more than 1174 is allowed, twice what a refresh and the first access after it can take
        |
     18 |         refi: 900, rfc: 288,
        |         ^
        |
     49 |         part: "lpddr4_3200.ron",
        |                ^
    "#);
}

/// Older configs name a level that is gone.
#[test]
fn a_level_that_is_gone() {
    let at_the_end = "machines: [\"small.ron\"],";
    insta::assert_snapshot!(experiment(at_the_end, "machines: [\"small.ron\"], fidelity: Functional,"), @r#"
    error: tiny.ron:10:40: the level Functional is gone: Event is exact for about the same time, Profile is faster; use Event or Profile
        |
     10 |     machines: ["small.ron"], fidelity: Functional,
        |                                        ^
    "#);
    let sampled = "machines: [\"small.ron\"], fidelity: Sampled(engine: Functional, rate: 0.1),";
    insta::assert_snapshot!(experiment(at_the_end, sampled), @r#"
    error: tiny.ron:10:56: the level Functional is gone: Event is exact for about the same time, Profile is faster; use Event or Profile
        |
     10 |     machines: ["small.ron"], fidelity: Sampled(engine: Functional, rate: 0.1),
        |                                                        ^
    "#);
}

#[test]
fn a_typo() {
    insta::assert_snapshot!(experiment("resolution", "resolutoin"), @r"
    error: tiny.ron:5:5: unknown field `resolutoin`; did you mean `resolution`? Allowed: `name`, `scene`, `frames`, `resolution`, `tracer`, `policies`, `machines`, `fidelity`, `split`, `replay`, `warmup`, `validate`
       |
     5 |     resolutoin: (width: 16, height: 16),
       |     ^
    ");
    insta::assert_snapshot!(experiment("Published()", "Publishd()"), @r#"
    error: tiny.ron:8:22: unknown name `Publishd`; did you mean `Published`? Allowed: `Off`, `Published`, `Symmetric`, `LastOccluder`, `OccluderGrid`, `HashPredictor`, `Sato`, `Certified`, `Hybrid`, `Oracle`
       |
     8 |         "Published": Publishd(),
       |                      ^
    "#);
    insta::assert_snapshot!(experiment("Published()", "Published(border: Lft)"), @r#"
    error: tiny.ron:8:40: unknown name `Lft`; allowed: `Occludes`, `Ignored`
       |
     8 |         "Published": Published(border: Lft),
       |                                        ^
    "#);
    insta::assert_snapshot!(experiment("policies: {", "policies: ["), @r"
    error: tiny.ron:6:14: Expected opening `{`
       |
     6 |     policies: [
       |              ^
    ");
    insta::assert_snapshot!(on_machine("shading_cycles", "shading_cycle"), @r"
    error: small.ron:14:9: unknown field `shading_cycle`; did you mean `shading_cycles`? Allowed: `rays`, `per_cycle`, `latency`, `in_fifo`, `out_fifo`, `ray_bytes`, `shading_cycles`
        |
     14 |         shading_cycle: 100, // assumed
        |         ^
    ");
}

#[test]
fn a_value_out_of_range() {
    insta::assert_snapshot!(experiment("width: 16", "width: 0"), @r"
    error: tiny.ron:5:38: a resolution of 0x16: each side can be from 1 to 8192
       |
     5 |     resolution: (width: 0, height: 16),
       |                                      ^
    ");
    insta::assert_snapshot!(experiment("\"tiny\"", "\"a/b\""), @r#"
    error: tiny.ron:2:12: the name `a/b`: 1 to 64 letters, digits, `-` and `_` are allowed
       |
     2 |     name: "a/b",
       |            ^
    "#);
    insta::assert_snapshot!(on_machine("clock_mhz: 500", "clock_mhz: 0"), @r"
    error: small.ron:6:16: 0 is not allowed here: a whole number from 1 to 10000 is
       |
     6 |     clock_mhz: 0, // TI, section 5
       |                ^
    ");
}

#[test]
fn sizes_that_do_not_fit_together() {
    insta::assert_snapshot!(on_machine("bytes: 16384, ways: 4", "bytes: 16384, ways: 3"), @"error: small.ron: `intersection.cache.bytes` is 16384: with lines of 64 B, 3 ways and 1 bank(s), 192 times a power of two is allowed");
    insta::assert_snapshot!(on_dram("row_bytes: 2048", "row_bytes: 32"), @"error: small.ron: the DRAM part LPDDR4-3200: `row_bytes` is 32: at least the line size, 64, is allowed");
    insta::assert_snapshot!(on_machine("mapping: [Column(1), Bank(3)", "mapping: [Column(1), Bank(2)"), @"error: small.ron: `dram.mapping` has 2 bit(s) of `Bank`: it needs 3, for 8 banks a group");
}

#[test]
fn a_space_of_what_is_not_there() {
    let desk = Desk::with_experiment();
    let with = |vary: &str, points: &str| {
        desk.put("space.ron", &format!("(experiment: \"tiny.ron\", vary: {{{vary}}}, points: {points})"));
        desk.refused(&["sweep", "space.ron", "--out", "s"])
    };
    let space = "Space(budget: 20)";
    let refused = [
        with("\"l2.ways\": []", space),
        with("\"l2.bytes\": Log(0, 65536)", space),
        with("\"l2.bytes\": Log(65536, 1024)", space),
        with("\"l2.bytes\": Log(1024, 3000)", space),
        with("\"traversal.count\": Integers(4, 1)", space),
        with("\"traversal.count\": Integers(0, 4)", space),
        with("\"traversal.cont\": Integers(1, 4)", space),
        with("\"traversal.count\": Loog(1, 4)", space),
        with("\"traversal.count\": Integers(1, 4)", "Single"),
        with("\"traversal.count\": Integers(1, 4)", "Space(budget: 3)"),
        with("\"traversal.count\": Integers(1, 4)", "Space(machines: 100000, budget: 30)"),
        with("\"traversal.count\": [4]", space),
        with("\"l2.bytes\": [3000, 5000]", space),
    ];
    insta::assert_snapshot!(refused.join("\n"));
}

#[test]
fn a_sweep_over_what_is_not_there() {
    let desk = Desk::with_experiment();
    let sweep = |vary: &str| {
        desk.put("sweep.ron", &format!("(experiment: \"tiny.ron\", vary: {{{vary}}})"));
        desk.refused(&["sweep", "sweep.ron", "--out", "s"])
    };
    let field = sweep("\"shadow_cache.layuot\": [Dense]");
    let known = "there is no field `layuot` in `shadow_cache`; did you mean `layout`? Allowed: `count`";
    assert!(field.contains("sweep.ron: `vary` has the value `Dense` for `shadow_cache.layuot`: "), "{field}");
    assert!(field.contains(known), "{field}");
    let value = sweep("\"shadow_cache.layout\": [Dnse]");
    assert!(
        value.contains("the value `Dnse` for `shadow_cache.layout`: unknown variant `Dnse`, expected one of `Dense`"),
        "{value}"
    );
}

#[test]
fn nothing_to_measure_against() {
    insta::assert_snapshot!(experiment("\"Off\": Off,", ""), @r#"
    error: tiny.ron:9:5: no policy is `Off`, which the others are measured against: add "Off": Off
       |
     9 |     },
       |     ^
    "#);
}

#[test]
fn frames_beyond_the_scene() {
    let desk = Desk::with_experiment();
    desk.put_changed("scene.ron", SCENE, "frame_count: 1000000", "frame_count: 120");
    insta::assert_snapshot!(desk.refused(&["trace", "tiny.ron", "-o", "x.rays", "--frames", "100..121"]), @"error: tiny.ron: `frames` is 100..121:1, but `floor` has frames 0 to 119: END can be up to 120");
}

#[test]
fn a_wrong_command_line() {
    let desk = Desk::with_experiment();
    let first = |args: &[&str]| desk.refused(args).lines().next().unwrap_or_default().to_owned();
    insta::assert_snapshot!(first(&["trace", "tiny.ron", "-o", "x.rays", "--policy", "Publshed"]), @"error: the experiment has no policy `Publshed`; it has `Off`, `Published`");
    insta::assert_snapshot!(first(&["run", "tiny.ron", "--frames", "9..3"]), @"error: invalid value '9..3' for '--frames <A..B:STEP>': `9..3` is no range of frames: write FIRST..END:STEP, such as 0..800:16, with FIRST below END; END is not included, and :STEP may be left out for 1");
    insta::assert_snapshot!(first(&["run", "tiny.ron", "--resolution", "512"]), @"error: invalid value '512' for '--resolution <WxH>': `512` is not a resolution: write WIDTHxHEIGHT, such as 512x512");
    insta::assert_snapshot!(first(&["run", "tiny.ron", "--threads", "0"]), @"error: invalid value '0' for '--threads <N>': 0 is not in 1..=1024");
    insta::assert_snapshot!(first(&["run", "absent.ron"]), @"error: cannot read absent.ron: No such file or directory (os error 2)");
}

#[test]
fn an_output_that_is_no_report() {
    let desk = Desk::with_experiment();
    std::fs::create_dir(desk.path("notes")).unwrap();
    desk.put("notes/todo.txt", "water the plants");
    insta::assert_snapshot!(desk.refused(&["run", "tiny.ron", "--out", "notes"]), @"error: notes is not an umbrasim report (it has no list of a report's files) and will not be overwritten");
    insta::assert_snapshot!(desk.refused(&["run", "tiny.ron", "--out", "notes/todo.txt"]), @"error: notes/todo.txt is not an umbrasim report (it has no list of a report's files) and will not be overwritten");
    insta::assert_snapshot!(desk.refused(&["plot", "notes"]), @"error: notes is not an umbrasim report (it has no list of a report's files) and will not be overwritten");
    insta::assert_snapshot!(desk.refused(&["trace", "tiny.ron", "-o", "notes"]), @"error: cannot create notes: it is a folder");
    insta::assert_snapshot!(desk.refused(&["trace", "tiny.ron", "-o", "nowhere/x.rays"]), @"error: cannot create nowhere/x.rays: there is no folder nowhere");
}
