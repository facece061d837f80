//! What `umbrasim replay` writes of its DRAM: requests for other simulators, and commands.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use common::{Desk, ROOT, error_text, machine};

const STREAM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/quickstart.rays");

/// The quick start's stream on a machine of `configs/machines`, exported; the measurements.
fn export(desk: &Desk, machine: &str, fidelity: &str, format: &str) -> Value {
    let machine = Path::new(ROOT).join("configs/machines").join(machine);
    let files = ["--dram-trace", "requests", "--dram-commands", "commands.csv", "--json", "stats.json"];
    let args = ["replay", STREAM, "--machine", machine.to_str().unwrap(), "--fidelity", fidelity];
    desk.succeed(&[&args[..], &files, &["--dram-trace-format", format]].concat());
    serde_json::from_slice(&fs::read(desk.path("stats.json")).unwrap()).unwrap()
}

fn read(desk: &Desk, name: &str) -> String {
    fs::read_to_string(desk.path(name)).unwrap()
}

#[test]
fn both_engines_write_the_same_bytes_and_measure_as_without() {
    let (event, cycle) = (Desk::new(), Desk::new());
    // Two channels, and a DRAM that is faster than the machine: several clocks a cycle.
    for machine in ["desktop.ron", "small.ron"] {
        let stats = export(&event, machine, "Event", "dramsim3");
        assert_eq!(stats, export(&cycle, machine, "Cycle", "dramsim3"));
        for file in ["requests", "commands.csv"] {
            assert!(read(&event, file) == read(&cycle, file), "{machine}: {file}");
        }
        let machine = Path::new(ROOT).join("configs/machines").join(machine);
        let plain = ["replay", STREAM, "--machine", machine.to_str().unwrap(), "--json", "plain.json"];
        event.succeed(&plain);
        assert_eq!(stats, serde_json::from_str::<Value>(&read(&event, "plain.json")).unwrap());
    }
}

#[test]
fn every_request_and_command_is_there() {
    let desk = Desk::new();
    let stats = export(&desk, "small.ron", "Event", "dramsim3");
    let count = |name: &str| stats["dram"][name].as_u64().unwrap();
    let requests = read(&desk, "requests");
    let mut last = 0;
    let (mut reads, mut writes) = (0, 0);
    for line in requests.lines() {
        let [address, kind, clock] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let address = u64::from_str_radix(address.strip_prefix("0x").unwrap(), 16).unwrap();
        assert_eq!(address % 32, 0, "{line}: a burst of LPDDR4 is 32 bytes");
        let clock: u64 = clock.parse().unwrap();
        assert!(last <= clock, "{line}");
        last = clock;
        *(if kind == "READ" { &mut reads } else { &mut writes }) += 1;
        assert!(["READ", "WRITE"].contains(&kind), "{line}");
    }
    // Two bursts a line.
    assert_eq!((reads, writes), (2 * count("reads"), 2 * count("writes")));

    let commands = read(&desk, "commands.csv");
    let (header, rest) = commands.split_once('\n').unwrap();
    assert_eq!(header, "clock,channel,command,bank_group,bank,row,column");
    let mut counts = BTreeMap::new();
    let mut last = None;
    for line in rest.lines() {
        let fields: Vec<_> = line.split(',').collect();
        let clock: u64 = fields[0].parse().unwrap();
        assert!(fields.len() == 7 && fields[1] == "0" && last.is_none_or(|last| last < clock), "{line}");
        last = Some(clock);
        *counts.entry(fields[2]).or_insert(0) += 1;
    }
    let get = |name: &str| counts.get(name).copied().unwrap_or(0);
    assert_eq!(get("RD"), 2 * count("reads"));
    assert_eq!(get("WR"), 2 * count("writes"));
    assert_eq!(get("REF"), count("refreshes"));
    assert!(get("ACT") >= count("row_misses") + count("row_conflicts"));
    assert!(get("PRE") >= count("row_conflicts") && get("PREA") > 0);
}

#[test]
fn ramulator_gets_loads_and_stores_in_order() {
    let desk = Desk::new();
    export(&desk, "small.ron", "Event", "dramsim3");
    let expected = read(&desk, "requests");
    let expected = expected.lines().map(|line| {
        let fields: Vec<_> = line.split(' ').collect();
        format!("{} {}\n", if fields[1] == "READ" { "LD" } else { "ST" }, fields[0])
    });
    let expected: String = expected.collect();
    export(&desk, "small.ron", "Event", "ramulator");
    assert!(read(&desk, "requests") == expected);
}

#[test]
fn what_cannot_be_exported_is_refused_and_leaves_nothing() {
    let desk = Desk::with_experiment();
    for fidelity in ["Bound", "Profile", "Sampled(engine: Event, rate: 0.5)"] {
        let replay = ["replay", STREAM, "--machine", "small.ron", "--dram-trace", "x", "--fidelity", fidelity];
        let output = desk.program(&replay).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let told =
            format!("error: `{fidelity}` does not replay cycle by cycle, and cannot be watched: Event and Cycle can\n");
        assert_eq!(error_text(&output), told);
    }
    desk.put_changed("flat.ron", &machine(), "channels: 1,", "channels: 1, model: Flat(latency: 50),");
    let flat = desk.program(&["replay", STREAM, "--machine", "flat.ron", "--dram-trace", "x"]).output().unwrap();
    assert_eq!(flat.status.code(), Some(2));
    let told =
        "error: a DRAM with `model: Flat` has no clocks and commands that could be told: for these, Banks is allowed\n";
    assert_eq!(error_text(&flat), told);
    let nowhere = ["replay", STREAM, "--machine", "small.ron", "--dram-commands", "nowhere/x.csv"];
    let output = desk.program(&nowhere).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(error_text(&output), "error: cannot write nowhere/x.csv: there is no folder nowhere\n");
    let full = ["replay", STREAM, "--machine", "small.ron", "--dram-trace", "x"];
    let output = desk.limited(8, &full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(error_text(&output), "error: cannot write x: File too large (os error 27)\n");
    assert!(!desk.path("x").exists());
}
