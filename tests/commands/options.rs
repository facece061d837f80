//! Options that commands share, and what is said of useless runs.

use super::common::{Desk, SCENE, error_text};
use super::fits;

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn fields_of_experiment_and_machines_are_set_on_the_command_line() {
    let desk = Desk::with_experiment();
    let set = ["--set", "traversal.cache.bytes=16KiB", "--set", "tracer.render.depth=2"];
    desk.prints(&[&["run", "tiny.ron", "--out", "a"][..], &set].concat());
    let config = std::fs::read_to_string(desk.path("a/config.ron")).unwrap();
    assert!(config.contains("bytes: 16384") && config.contains("depth: 2"), "{config}");
    let refused = |setting| desk.refuses(&["run", "tiny.ron", "--out", "b", "--set", setting]);
    insta::assert_snapshot!(refused("traversal.cach.bytes=16KiB"), @"error: --set traversal.cach.bytes=16KiB: there is no field `cach` in `traversal`; did you mean `cache`? Allowed: `count`, `latency`, `interval`, `rays`, `cache`");
    insta::assert_snapshot!(refused("traversal.cache.bytes=16KB"), @"error: --set traversal.cache.bytes=16KB: `16KB` is no size: a number of B, kB, MB, GB (of 1000), KiB, MiB or GiB (of 1024) is");
    insta::assert_snapshot!(refused("traversal.cache.ways=0"), @"error: --set traversal.cache.ways=0: 0 is not allowed here: a whole number from 1 to 64 is");
    assert!(!desk.path("b").exists());
    desk.prints(&["trace", "tiny.ron", "-o", "s.rays", "--frames", "0..1"]);
    let cycles = |setting: &[&str]| {
        let args = [&["replay", "s.rays", "--machine", "small.ron", "--json"][..], setting].concat();
        json(&desk.prints(&args))["cycles"].as_u64().unwrap()
    };
    assert!(cycles(&["--set", "traversal.cache.latency=90"]) > cycles(&[]));
}

/// Nothing of what is asked for is dropped, and no folder that is not there is passed over.
#[test]
fn what_contradicts_itself_is_refused() {
    let desk = Desk::with_experiment();
    desk.put_changed("other.ron", &super::common::machine(), "clock_mhz: 500", "clock_mhz: 600");
    desk.put("sweep.ron", "(experiment: \"tiny.ron\", vary: {\"clock_mhz\": [400]})");
    desk.put("named.ron", "(experiment: \"tiny.ron\", vary: {\"name\": [\"a\"]})");
    desk.put("twice.ron", "(experiment: \"tiny.ron\", vary: {\"clock_mhz\": [400, 400]})");
    desk.put(
        "pareto.ron",
        "(experiments: [(file: \"tiny.ron\"), (file: \"tiny.ron\")], machines: [\"small\"], rungs: [Bound])",
    );
    desk.put("sweep\nof.ron", "(experiment: \"tiny.ron\", vary: {\"clock_mhz\": [400]})");
    desk.prints(&["trace", "tiny.ron", "-o", "s.rays", "--frames", "0..1"]);
    for (args, said) in [
        (&["replay", "s.rays", "--machine", "small.ron,other.ron"][..], "names two machines called `small`"),
        (&["replay", "s.rays", "--machine", "small", "--set", "l2.ways=2", "--set", "l2.ways=4"], "`l2.ways` twice"),
        (&["run", "tiny.ron", "--frames", "0..1", "--set", "frames=\"0..2\""], "`--frames` sets `frames` too"),
        (&["pareto", "pareto.ron"], " of `tiny`"),
        (&["sweep", "named.ron"], "`vary` has `name`"),
        (&["sweep", "twice.ron"], "`vary` has `400` twice"),
        (&["sweep", "sweep.ron", "--collect", "absent"], "--collect absent: there is no such folder"),
        (&["sweep", "sweep.ron", "--shard", "1/2", "--shards", "2"], "--shards"),
        (&["sweep", "sweep.ron", "--emit", "hq", "-", "--shards", "50"], "`--shards` is 50"),
        (&["sweep", "sweep\nof.ron", "--emit", "hq", "-"], "control character"),
        (&["profile", "s.rays", "--machine", "small", "--hot", "5"], "--sample"),
        (&["stress", "--case", "C1,C1"], "the case `C1` is named twice"),
    ] {
        let told = desk.refuses(args);
        assert!(told.contains(said), "{args:?}: {told}");
    }
    let script = desk.prints(&["sweep", "sweep.ron", "--emit", "hq", "-", "--threads", "7"]);
    assert!(script.contains("#HQ --cpus=7") && script.contains("--threads 7 sweep"), "{script}");
}

#[test]
fn several_machines_are_named_in_a_list() {
    let desk = Desk::with_experiment();
    let summary =
        json(&desk.prints(&["run", "tiny.ron", "--machine", "small,ideal", "--machine", "desktop", "--json"]));
    let machines: Vec<&String> = summary["machines"].as_object().unwrap().keys().collect();
    assert_eq!(machines, ["small", "ideal", "desktop"]);
    desk.prints(&["trace", "tiny.ron", "-o", "s.rays", "--frames", "0..1"]);
    let told = desk.prints(&["replay", "s.rays", "--machine", "small,desktop"]);
    assert!(fits(&told, 80), "{told}");
    assert_eq!(told.matches("Model: Event (exact; no sampling)").count(), 2, "{told}");
    assert_eq!(told.matches("Least that any such machine takes: ").count(), 2, "{told}");
    assert!(!told.contains("Bounds: "), "{told}");
    let message = desk.refuses(&["replay", "s.rays", "--machine", "small,dekstop"]);
    assert!(message.contains("did you mean `desktop`?"), "{message}");
}

#[test]
fn quiet_and_json_say_nothing_else() {
    let desk = Desk::with_experiment();
    let output = desk.program(&["run", "tiny.ron", "--out", "a", "--quiet"]).output().unwrap();
    assert_eq!(String::from_utf8(output.stdout.clone()).unwrap(), "a/index.html\n");
    assert!(output.stderr.is_empty(), "{}", error_text(&output));
    let printed = json(&desk.prints(&["run", "tiny.ron", "--out", "b", "--json"]));
    let there = json(&std::fs::read_to_string(desk.path("b/summary.json")).unwrap());
    assert_eq!(printed["machines"], there["machines"]);
}

#[test]
fn a_run_tells_its_finding_in_80_columns() {
    let desk = Desk::with_experiment();
    let output = desk.program(&["run", "tiny.ron", "--out", "a"]).output().unwrap();
    let told = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(fits(&told, 80), "{told}");
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines.last(), Some(&"report: a/index.html"), "{told}");
    for part in ["ms/frame", "DRAM MB/frame", ": a frame takes ", "wrong shadow decisions in all frames: "] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(!told.contains("\u{b1} time"), "all runs are exact: {told}");
    assert!(error_text(&output).contains("took "), "{}", error_text(&output));
    let wide = desk.program(&["run", "tiny.ron", "--out", "a"]).env("COLUMNS", "120").output().unwrap();
    let wide = String::from_utf8(wide.stdout).unwrap();
    assert!(fits(&wide, 120) && wide.contains("energy/frame"), "{wide}");
}

#[test]
fn a_file_of_another_kind_is_told() {
    let desk = Desk::with_experiment();
    insta::assert_snapshot!(desk.refuses(&["run", "small.ron"]), @"error: small.ron is a machine file: use --machine small.ron; an experiment file is needed here");
    desk.prints(&["trace", "tiny.ron", "-o", "s.rays", "--frames", "0..1"]);
    insta::assert_snapshot!(desk.refuses(&["replay", "s.rays", "--machine", "tiny.ron"]), @"error: tiny.ron is an experiment file: use umbrasim run tiny.ron; a machine file is needed here");
}

#[test]
fn files_in_a_sweep_lie_beside_it() {
    let desk = Desk::with_experiment();
    std::fs::create_dir(desk.path("study")).unwrap();
    desk.put("study/other.ron", &super::common::dram_part());
    let vary = "vary: {\"dram.part\": [\"other.ron\"]}";
    desk.put("study/sweep.ron", &format!("(experiment: \"../tiny.ron\", frames: \"0..1\", {vary})"));
    let told = desk.prints(&["sweep", "study/sweep.ron", "--out", "out"]);
    // It is the same part as the machine's, so that there is no other point.
    assert!(told.contains("baseline"), "{told}");
}

#[test]
fn a_scene_that_shows_nothing_is_warned_of() {
    let desk = Desk::with_experiment();
    let told = |scene: &str, args: &[&str]| {
        desk.put("scene.ron", scene);
        let output = desk.program(&[&["run", "tiny.ron", "--out", "a"][..], args].concat()).output().unwrap();
        assert!(output.status.success(), "{}", error_text(&output));
        error_text(&output) + &String::from_utf8(output.stdout).unwrap()
    };
    let lights = SCENE.find("lights: [").unwrap();
    let end = lights + SCENE[lights..].find(']').unwrap() + 1;
    let dark = format!("{}lights: []{}", &SCENE[..lights], &SCENE[end..]);
    assert!(told(&dark, &[]).contains("has no lights: there is no shadow ray"), "{dark}");
    let fov = SCENE.find("fov: ").unwrap();
    let end = fov + SCENE[fov..].find(',').unwrap();
    let narrow = format!("{}fov: Vertical(0.7){}", &SCENE[..fov], &SCENE[end..]);
    assert!(told(&narrow, &[]).contains("sees 0.7 degrees from bottom to top: `fov` is in degrees"), "{narrow}");
}

#[test]
fn useless_runs_are_warned_of() {
    let desk = Desk::with_experiment();
    let warned = |args: &[&str]| {
        let output = desk.program(&[&["run", "tiny.ron", "--out", "a"][..], args].concat()).output().unwrap();
        assert!(output.status.success(), "{}", error_text(&output));
        error_text(&output).lines().filter(|line| line.starts_with("warning: ")).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(warned(&[]), "");
    insta::assert_snapshot!(warned(&["--frames", "0..1", "--set", "machines=[]"]), @r"
    warning: `machines` is empty: no machine is measured; name one, as in `--machine small`
    warning: `Published` learns from frame to frame, and there is one frame: at least two show what it saves
    ");
    desk.put_changed("small.ron", &super::common::machine(), "l2: Unified(", "// Unified(");
    insta::assert_snapshot!(warned(&[]), @"warning: small.ron has no `l2`: one cache of 128 KiB for all classes stands for it");
}

/// Whatever the levels are called: bounds tell no change, and a level without a known error is named beside its change.
#[test]
fn a_run_claims_what_its_level_knows() {
    let desk = Desk::with_experiment();
    let run = |fidelity: &str| {
        let setting = format!("fidelity={fidelity}");
        desk.prints(&["run", "tiny.ron", "--frames", "0..2", "--set", &setting, "--out", "r"])
    };
    let claims = ["Event", "Profile", "Bound"].map(|level| {
        let printed = run(level).replace('\n', " ");
        (printed.contains(": a frame takes "), printed.contains("error unknown"))
    });
    assert_eq!(claims, [(true, false), (true, true), (false, false)]);
}
