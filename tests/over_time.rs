//! `replay --timeline` and `--interval`, as a user calls them.

use std::fs;
use std::path::Path;

use assert_cmd::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn replay(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("umbrasim").unwrap();
    let stream = Path::new(ROOT).join("traces/quickstart.rays");
    command.arg("replay").arg(stream).args(["--machine", "small"]).args(arguments);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn counters_go_to_standard_output_and_the_table_beside_them() {
    let output = replay(&["--interval", "5000"]).output().unwrap();
    let (rows, told) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{told}");
    assert!(rows.starts_with("frame,warmup,begin,cycles,rays,bytes."), "{rows}");
    let mut csv = csv::Reader::from_reader(output.stdout.as_slice());
    let cycles = csv.headers().unwrap().iter().position(|name| name == "cycles").unwrap();
    let lengths: Vec<u64> = csv.records().map(|row| row.unwrap()[cycles].parse().unwrap()).collect();
    assert!(lengths.len() > 1 && lengths.iter().all(|&cycles| cycles <= 5000), "{lengths:?}");
    assert!(told.contains("DRAM traffic"), "the table goes to standard error: {told}");
}

/// An interval that is longer than any run is one row a frame, up to the largest number of cycles there is.
#[test]
fn an_interval_may_be_longer_than_a_run() {
    let output = replay(&["--interval", &u64::MAX.to_string()]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(csv::Reader::from_reader(output.stdout.as_slice()).records().count(), 4);
}

#[test]
fn a_timeline_comes_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.perfetto");
    let file = path.to_str().unwrap();
    let refused = replay(&["--timeline", file, "--fidelity", "Profile"]).output().unwrap();
    let told = text(&refused.stderr);
    assert!(
        told.contains("`Profile` does not replay cycle by cycle") && told.contains("Event and Cycle can"),
        "{told}"
    );
    assert_eq!((refused.status.code(), path.exists()), (Some(2), false));
    let refused = replay(&["--timeline", file, "--timeline-frame", "77"]).output().unwrap();
    assert!(text(&refused.stderr).contains("there is no frame 77"), "{}", text(&refused.stderr));
    let both = replay(&["--timeline", file, "--interval", "9", "--interval-out", file]).output().unwrap();
    assert!(text(&both.stderr).contains("are the same file"), "{}", text(&both.stderr));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let written = replay(&["--timeline", file]).output().unwrap();
    assert!(written.status.success() && text(&written.stdout).contains("slices"), "{}", text(&written.stderr));
    assert!(fs::read(&path).unwrap().starts_with(&[0x0a]), "packets of a trace");
}
