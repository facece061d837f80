//! The tag arrays of caches against pycachesim: `tests/fixtures/pycachesim` holds what it counted on line streams of
//! the quick start, and the script that asked it.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use common::{Desk, ROOT, error_text};
use umbrasim::memory::replacement::Policy;
use umbrasim::memory::tags::TagArray;
use umbrasim::quantity::LineAddr;
use umbrasim::stats::TrafficClass;

/// The arguments that write the line stream of a cache to a file of its name.
fn export<'a>(stream: &'a str, machine: &'a str, cache: &'a str) -> [&'a str; 10] {
    let fidelity = ["--fidelity", "Bound"];
    let [a, b] = fidelity;
    ["replay", stream, "--machine", machine, a, b, "--line-trace", cache, "--line-trace-cache", cache]
}

const STREAM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/quickstart.rays");
const MACHINE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/machines/small_naive.ron");

/// Misses, and dirty lines displaced, of an array that is filled at once.
fn counted(accesses: &[(bool, LineAddr)], mut tags: TagArray) -> (u64, u64) {
    let (mut misses, mut write_backs) = (0, 0);
    for &(write, line) in accesses {
        if !tags.access(line, write) {
            misses += 1;
            let victim = tags.fill(line, TrafficClass::Node, write);
            write_backs += u64::from(victim.is_some_and(|victim| victim.dirty));
        }
    }
    (misses, write_backs)
}

#[test]
fn misses_and_write_backs_are_the_same() {
    let desk = Desk::new();
    let mut streams: BTreeMap<String, Vec<(bool, LineAddr)>> = BTreeMap::new();
    let table = fs::read_to_string(Path::new(ROOT).join("tests/fixtures/pycachesim/counts.csv")).unwrap();
    let (mut rows, mut dirty) = (0, 0);
    for row in table.lines().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        let number = |index: usize| fields[index].parse::<u64>().unwrap();
        let accesses = streams.entry(fields[0].into()).or_insert_with(|| {
            desk.succeed(&export(STREAM, MACHINE, fields[0]));
            let text = fs::read_to_string(desk.path(fields[0])).unwrap();
            let access = |line: &str| {
                let (kind, address) = line.split_once(' ').unwrap();
                (kind == "1", LineAddr(u64::from_str_radix(address, 16).unwrap() / 64))
            };
            text.lines().map(access).collect()
        });
        assert_eq!(accesses.len() as u64, number(1), "{row}: the stream is another one, run make.py again");
        let policy = if fields[2] == "LRU" { Policy::Lru } else { Policy::Fifo };
        let tags = TagArray::new(number(3) as usize, number(4) as usize, 0, policy);
        assert_eq!(counted(accesses, tags), (number(5), number(6)), "{row}");
        (rows, dirty) = (rows + 1, dirty + number(6));
    }
    assert!(rows == 30 && dirty > 0);
}

#[test]
fn a_cache_that_is_not_there_is_refused() {
    let desk = Desk::new();
    let output = desk.program(&export(STREAM, MACHINE, "l3")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = "error: there is no L1 called `l3`: l1_traversal, l1_list, l1_intersection, l1_shadow_cache are\n";
    assert_eq!(error_text(&output), told);
}
