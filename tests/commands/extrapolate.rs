//! `extrapolate`, as a user calls it.

use serde_json::Value;

use super::common::Desk;
use super::fits;

/// A desk with a recorded stream of 64x64 pixels.
fn desk() -> Desk {
    let desk = Desk::with_experiment();
    desk.prints(&["trace", "tiny.ron", "-o", "s.rays", "--frames", "0..1", "--resolution", "64x64"]);
    desk
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn few_cores_tell_many_and_a_check_says_how_well() {
    let desk = desk();
    let args = ["extrapolate", "s.rays", "--machine", "small", "--cores", "8", "--check"];
    let told = desk.prints(&args);
    assert!(fits(&told, 80), "{told}");
    for part in ["model of 2 cores", "model of 4 cores", "8 cores, predicted", "8 cores, Event", "8 channels of LPDDR4"]
    {
        assert!(told.contains(part), "{part}: {told}");
    }
    let found = json(&desk.prints(&[&args[..], &["--json"]].concat()));
    for (figure, allowed) in [("cycles", 0.10), ("l2_bytes", 0.10), ("dram_bytes", 0.10)] {
        let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{figure}: {found}"));
        let [value, low, high, least] =
            ["value", "low", "high", "least"].map(|kind| number(&found["predicted"][figure][kind]));
        let truth = number(&found["checked"][figure]);
        assert!((value / truth - 1.0).abs() < allowed, "{figure}: {value} for {truth}");
        assert!(least <= low && low <= value && value <= high && least <= truth, "{figure}: {found}");
    }
    let [energy, truth] = [&found["joules"]["value"], &found["checked_joules"]].map(|it| it.as_f64().unwrap());
    assert!((energy / truth - 1.0).abs() < 0.02, "{energy} J for {truth}");
    assert!(told.contains("energy") && told.contains("µJ"), "{told}");
    let again =
        desk.prints(&["extrapolate", "s.rays", "--machine", "small", "--cores", "8", "--json", "--threads", "1"]);
    assert_eq!(json(&again)["predicted"], found["predicted"], "threads and checks change nothing");
    assert_eq!(json(&again)["checked"], Value::Null);
}

#[test]
fn a_report_has_the_models_of_all_machines_and_nothing_of_others_is_lost() {
    let desk = desk();
    let args = ["extrapolate", "s.rays", "--machine", "small", "--models", "1,2", "--fidelity", "Profile"];
    let told = desk.prints(&[&args[..], &["--cores", "4,8", "--out", "many"]].concat());
    assert!(told.contains("report: many/index.html"), "{told}");
    let table = std::fs::read_to_string(desk.path("many/extrapolate.csv")).unwrap();
    assert!(table.contains(",small,8,energy,J,predicted,,"), "{table}");
    std::fs::create_dir(desk.path("mine")).unwrap();
    std::fs::write(desk.path("mine/notes.txt"), "mine").unwrap();
    let refused = desk.refuses(&[&args[..], &["--cores", "4", "--out", "mine"]].concat());
    assert!(refused.contains("mine"), "{refused}");
    assert_eq!(std::fs::read_to_string(desk.path("mine/notes.txt")).unwrap(), "mine");
}

#[test]
fn several_large_machines_are_a_list() {
    let desk = desk();
    let args =
        ["extrapolate", "s.rays", "--machine", "small", "--cores", "4,8", "--models", "1,2", "--fidelity", "Profile"];
    let found = json(&desk.prints(&[&args[..], &["--json"]].concat()));
    let cores: Vec<_> = found.as_array().unwrap().iter().map(|it| it["cores"].as_u64().unwrap()).collect();
    assert_eq!(cores, [4, 8]);
    assert_eq!(found[0]["models"].as_array().unwrap().len(), 2);
}

#[test]
fn what_cannot_be_extrapolated_is_refused_by_its_name() {
    let desk = desk();
    let refused = |of: &[&str]| desk.refuses(&[&["extrapolate", "s.rays", "--machine"], of].concat());
    let cases: [(&[&str], &str); 6] = [
        (&["small"], "small has 1 core: --cores says how many the large machine has"),
        (
            &["small", "--cores", "8", "--models", "2,3"],
            "small of 8 cores has no model of 3: a number below 8 is allowed that divides it",
        ),
        (
            &["small", "--cores", "8", "--fidelity", "Bound"],
            "`Bound` does not replay scale models, each of which has a share of the pixels: Profile, Event and \
             Cycle do",
        ),
        (
            &["desktop", "--cores", "16"],
            "desktop with 16 cores: `dram.channels`: 128 is not allowed here: a power of two from 1 to 64 is \
             (--channels says how many)",
        ),
        (
            &["small", "--cores", "65"],
            "small with 65 cores: `cores`: 65 is not allowed here: a whole number from 1 to 64 is",
        ),
        (
            &["desktop_traffic", "--cores", "8"],
            "desktop_traffic of 8 cores has no model of 2: `traffic` is on, whose port is one, whatever the number of \
             cores: `traffic: ()` is allowed",
        ),
    ];
    for (args, expected) in cases {
        assert_eq!(refused(args).trim_end(), format!("error: {expected}"));
    }
}
