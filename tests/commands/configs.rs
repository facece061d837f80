//! Commands about configs.

use super::common::{Desk, error_text};
use super::fits;

#[test]
fn a_field_is_described_with_all_that_its_spec_says() {
    let desk = Desk::new();
    insta::assert_snapshot!(desk.prints(&["describe", "machine.traversal.cache.bytes"]), @r"
    machine.traversal.cache.bytes

     meaning  Size in bytes.
     type     size
     unit     bytes
     range    32 B to 256 MiB
     default  8 KiB
     source   the T&I engine's traversal cache (Nah et al. 2011, section 5: 8 KB, 2
              ways, latency 1, one port; 8 rows of 4 rays wait for lines).
    ");
    let group = desk.prints(&["describe", "machine.shadow_cache"]);
    assert!(fits(&group, 80), "{group}");
    for part in [
        "Source: assumed",
        "\n place ",
        "Which way accesses to stores go.",
        "default Own",
        "describe machine.shadow_cache.writes",
    ] {
        assert!(group.contains(part), "{part}: {group}");
    }
    let experiment = desk.prints(&["describe", "experiment"]);
    for field in ["name", "scene", "frames", "resolution >", "policies >", "machines", "warmup", "validate"] {
        assert!(experiment.contains(&format!("\n {field} ")), "{field}: {experiment}");
    }
    assert!(desk.prints(&["describe"]).contains("scene"));
}

#[test]
fn a_field_that_is_not_there_is_told_with_one_that_is() {
    let desk = Desk::new();
    insta::assert_snapshot!(desk.refuses(&["describe", "machine.shadow_cach"]), @r"
    error: `machine` has no `shadow_cach`; did you mean `shadow_cache`?
    allowed: `name`, `clock_mhz`, `line_bytes`, `cores`, `dispatcher`, `traversal`, `list`, `intersection`, `division`, `shadow_cache`, `l2`, `dram`, `traffic`, `energy`
    ");
    insta::assert_snapshot!(desk.refuses(&["describe", "cache.bytes"]), @r"
    error: there is no kind of file `cache`; did you mean `machine.traversal.cache.bytes`?
    allowed: `experiment`, `machine`, `scene`, `sweep`, `dram`, `pareto`, `identities`, `paper_table`
    ");
}

/// A file without `.ron` would stand for a shipped config of its name. An experiment's name has rules of its own.
#[test]
fn a_new_file_has_a_name_that_it_can_be_used_by() {
    let desk = Desk::new();
    let told = desk.refuses(&["new", "machine", "small", "--from", "desktop"]);
    assert!(told.contains("small: the file's name needs the ending .ron; a file without one would"), "{told}");
    let told = desk.refuses(&["new", "experiment", "my run.ron"]);
    assert!(told.contains("my run.ron: the name `my run`: 1 to 64 letters, digits, `-` and `_` are allowed"), "{told}");
    let told = desk.refuses(&["new", "experiment", "run.ron", "--from", "pareto"]);
    assert!(told.contains("`pareto` is of the kind pareto: `new experiment` cannot start from it"), "{told}");
    assert!(desk.contents().is_empty(), "nothing is written");
}

#[test]
fn the_record_of_a_run_is_no_experiment() {
    let desk = Desk::with_experiment();
    desk.prints(&["run", "tiny.ron", "--frames", "0..1", "--out", "r"]);
    for command in ["run", "check"] {
        let told = desk.refuses(&[command, "r/config.ron"]);
        assert!(told.contains("r/config.ron is a report's record of what was run"), "{told}");
    }
}

/// A folder of a shipped config's name is no config.
#[test]
fn a_name_is_a_shipped_config_beside_a_folder_of_that_name() {
    let desk = Desk::new();
    std::fs::create_dir(desk.path("small")).unwrap();
    assert!(desk.prints(&["check", "small"]).contains("a machine file"));
}

#[test]
fn a_new_file_runs_and_is_not_overwritten() {
    let desk = Desk::new();
    for (kind, from) in
        [("machine", "desktop"), ("scene", "street"), ("sweep", "sweep_words"), ("experiment", "quickstart")]
    {
        let file = format!("{kind}.ron");
        desk.prints(&["new", kind, "--from", from, &file]);
        let text = std::fs::read_to_string(desk.path(&file)).unwrap();
        let note = text.strip_prefix("#![type = \"umbrasim::").and_then(|text| text.split_once("\n"));
        assert!(note.unwrap().1.contains(&format!(" {kind} that started as `{from}`.")), "{text}");
        let message = desk.refuses(&["new", kind, "--from", from, &file]);
        assert!(message.contains("is there already"), "{message}");
        assert_eq!(std::fs::read_to_string(desk.path(&file)).unwrap(), text);
    }
    assert!(std::fs::read_to_string(desk.path("machine.ron")).unwrap().contains("name: \"machine\""));
    let told = desk.prints(&["check", "machine.ron", "scene.ron", "sweep.ron"]);
    insta::assert_snapshot!(told, @r"
    machine.ron: a machine file; `machine`, up to 224.0 GB/s of DRAM traffic; about
    2 MB of memory
    scene.ron: a scene file; `street`, 74,454 static and 11,400 dynamic triangles, 6
    lights, 120 frames
    sweep.ron: a sweep file; 32 machines
    ");
}

#[test]
fn an_experiment_is_checked_without_a_run() {
    let desk = Desk::with_experiment();
    let before = desk.contents();
    let told = desk.prints(&["check", "tiny.ron", "lpddr4_3200.ron"]);
    let told = told.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "tiny.ron: an experiment file; ",
        " MB of memory; about ",
        " rays without culling, about ",
        "a file of a DRAM part",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(desk.contents() == before, "files were made");
}

#[test]
fn what_is_wrong_in_a_file_is_told_whatever_its_kind() {
    let desk = Desk::with_experiment();
    desk.put("machine.ron", "(traversal: (count: 0))");
    insta::assert_snapshot!(desk.refuses(&["check", "tiny.ron", "machine.ron"]), @r"
    error: machine.ron:1:21: 0 is not allowed here: a whole number from 1 to 1024 is
       |
     1 | (traversal: (count: 0))
       |                     ^
    ");
    desk.put("nothing.ron", "(a: 1)");
    let told = desk.refuses(&["check", "nothing.ron"]);
    let kinds = "an experiment file, a machine file, a scene file, a sweep file, a file of a DRAM part, a comparison \
                 of fidelity levels, a table of rays of one kind, a table of readings of the paper";
    let type_line = "A first line such as `#![type = \"umbrasim::Machine\"]` tells it";
    let expected = format!("the names at its top tell no kind of config; known are {kinds}. {type_line}");
    assert_eq!(told.trim_end(), format!("error: nothing.ron: {expected}"));
}

#[test]
fn editors_get_a_schema_of_each_kind() {
    let desk = Desk::new();
    desk.prints(&["schema", "out"]);
    for kind in ["Experiment", "Machine", "Scene", "Sweep", "DramPart", "CacheSpec"] {
        let text = std::fs::read_to_string(desk.path(&format!("out/umbrasim/{kind}.schema.ron"))).unwrap();
        assert!(text.contains("kind: Struct") || text.contains("kind: Enum"), "{kind}: {text}");
    }
    desk.put("typed.ron", "#![type = \"umbrasim::Machine\"]\n(name: \"typed\")");
    assert!(desk.prints(&["check", "typed.ron"]).contains("`typed`"));
    assert!(desk.prints(&["check", "small"]).starts_with("small: a machine file; `small`"));
}

#[test]
fn shells_and_manuals_know_the_commands() {
    let desk = Desk::new();
    for shell in ["bash", "zsh", "fish"] {
        assert!(desk.prints(&["completions", shell]).contains("ladder-map"), "{shell}");
    }
    assert!(desk.prints(&["man"]).contains(".TH umbrasim 1"));
    desk.prints(&["man", "--out", "pages"]);
    let page = std::fs::read_to_string(desk.path("pages/umbrasim-replay.1")).unwrap();
    assert!(page.contains("fidelity") && desk.path("pages/umbrasim.1").exists(), "{page}");
}

#[test]
fn a_mesh_alone_is_a_scene_and_can_become_a_config() {
    let desk = Desk::with_experiment();
    let output = desk.program(&["run", "tiny.ron", "--scene", "kite.obj", "--frames", "0..2", "--out", "r"]).output();
    let output = output.unwrap();
    let told = error_text(&output);
    assert!(output.status.success() && told.contains("kite.obj has no config: a camera goes round it"), "{told}");
    desk.succeed(&["new", "scene", "kite.ron", "--mesh", "kite.obj"]);
    let same = ["run", "tiny.ron", "--scene", "kite.ron", "--frames", "0..2", "--out", "s"];
    desk.succeed(&same);
    let frames = |folder: &str| std::fs::read_to_string(desk.path(folder).join("frames.csv")).unwrap();
    assert!(frames("r") == frames("s"));
    let told = error_text(&desk.program(&["new", "machine", "m.ron", "--mesh", "kite.obj"]).output().unwrap());
    assert!(told.contains("`--mesh` is of a scene, and this is a machine"), "{told}");
}
