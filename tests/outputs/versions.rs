//! Streams that an earlier umbrasim recorded can still be replayed, and measure the same.

use std::path::Path;

use serde_json::Value;

use super::common::{Desk, ROOT, error_text};

const STREAMS: [&str; 2] = ["published", "occluder"];

fn fixture(file: &str) -> String {
    Path::new(ROOT).join("tests/fixtures/version_2").join(file).to_str().unwrap().into()
}

fn machine(name: &str) -> String {
    Path::new(ROOT).join("configs/machines").join(name).with_extension("ron").to_str().unwrap().into()
}

/// All that `then` states is in `now`, too.
fn assert_holds(now: &Value, then: &Value, at: &str) {
    match then {
        Value::Object(fields) => fields.iter().for_each(|(key, value)| {
            assert_holds(&now[key], value, &format!("{at}/{key}"));
        }),
        _ => assert_eq!(now, then, "{at}"),
    }
}

#[test]
fn a_stream_of_version_2_measures_what_it_measured_then() {
    let desk = Desk::new();
    let figures: Value = serde_json::from_slice(&std::fs::read(fixture("figures.json")).unwrap()).unwrap();
    for stream in STREAMS {
        for (name, then) in figures[stream].as_object().unwrap() {
            let file = fixture(&format!("{stream}.rays"));
            desk.succeed(&["replay", &file, "--machine", &machine(name), "--json", "now.json"]);
            let now = serde_json::from_slice(&std::fs::read(desk.path("now.json")).unwrap()).unwrap();
            assert_holds(&now, then, &format!("{stream} on {name}"));
        }
    }
}

#[test]
fn every_level_and_command_reads_version_2() {
    let desk = Desk::new();
    for stream in STREAMS {
        let file = fixture(&format!("{stream}.rays"));
        let shown = desk.succeed(&["inspect", &file]);
        assert!(shown.contains("version 2, "), "{shown}");
        desk.succeed(&["profile", &file, "--machine", &machine("small_naive"), "--out", stream]);
        for level in ["Bound", "Profile", "Cycle", "Sampled(engine: Event, rate: 1)", "Auto(error: 0.5)"] {
            desk.succeed(&["replay", &file, "--machine", &machine("small_naive"), "--fidelity", level]);
        }
    }
}

#[test]
fn a_machine_that_drops_silent_updates_needs_to_know_which_are() {
    let desk = Desk::new();
    for command in ["replay", "profile"] {
        let args = |stream| [command.into(), fixture(stream), "--machine".into(), machine("small")];
        let output = desk.program(&args("published.rays").each_ref().map(String::as_str)).output().unwrap();
        let said = error_text(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        for part in ["`shadow_cache.silent` is Latched", "version 2", "record the stream again", "small_naive"] {
            assert!(said.contains(part), "{part}: {said}");
        }
        assert!(desk.contents().is_empty(), "nothing is written");
    }
    // A policy without mode words has no such updates.
    desk.succeed(&["replay", &fixture("occluder.rays"), "--machine", &machine("small")]);
}
