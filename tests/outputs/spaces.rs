//! Spaces of machines: few replays, the same bytes whatever stops them.

use std::fs;
use std::path::PathBuf;

use super::common::{Desk, error_text};

const SPACE: &str = "(experiment: \"tiny.ron\", frames: \"0..2\", vary: {
    \"traversal.count\": Integers(1, 4),
    \"traversal.cache.bytes\": Log(128, \"8 KiB\"),
    \"shadow_cache.cache.bytes\": Log(128, 1024),
}, points: Space(machines: 60, budget: 20))";

fn desk() -> Desk {
    let desk = Desk::with_experiment();
    desk.put("space.ron", SPACE);
    desk
}

/// The numbers of a space's report.
fn numbers(desk: &Desk, folder: &str) -> [Vec<u8>; 3] {
    ["summary.json", "results.csv", "space.csv"].map(|file| fs::read(desk.path(folder).join(file)).unwrap())
}

fn points(desk: &Desk, folder: &str) -> Vec<PathBuf> {
    let is_point = |path: &PathBuf| ["pixels", "estimates"].iter().all(|what| !path.to_string_lossy().contains(what));
    kept(desk, folder).into_iter().filter(is_point).collect()
}

/// What a space keeps: points, wrong pixels, and what its passes told.
fn kept(desk: &Desk, folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(desk.path(folder).join("points")).unwrap();
    let mut kept: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    kept.sort();
    kept
}

#[test]
fn a_space_is_the_same_whatever_stops_it() {
    let desk = desk();
    let told = desk.succeed(&["sweep", "space.ron", "--out", "whole", "--threads", "1"]);
    let whole = numbers(&desk, "whole");
    assert_eq!(points(&desk, "whole").len(), 20);

    // What lacks points goes on, and damaged ones are made again.
    let passes: Vec<PathBuf> =
        self::kept(&desk, "whole").into_iter().filter(|path| path.to_string_lossy().contains("estimates")).collect();
    let written = |path: &PathBuf| fs::metadata(path).unwrap().modified().unwrap();
    let before: Vec<_> = passes.iter().map(written).collect();
    let kept = points(&desk, "whole");
    kept.iter().step_by(3).for_each(|point| fs::remove_file(point).unwrap());
    fs::write(&kept[1], "{").unwrap();
    let resumed = desk.succeed(&["sweep", "space.ron", "--out", "whole", "--threads", "2"]);
    assert!(numbers(&desk, "whole") == whole);
    // Passes are not made again.
    assert!(!passes.is_empty() && passes.iter().map(written).eq(before));
    // All but the last two lines, which tell the time and the place.
    let table = |text: &str| text.split("\nreport: ").next().unwrap().to_owned();
    assert_eq!(table(&told), table(&resumed));
    assert!(told.lines().all(|line| line.chars().count() <= 80), "{told}");

    // The first set by shards, the rest by what comes after.
    for shard in ["2/2", "1/2"] {
        desk.succeed(&["sweep", "space.ron", "--out", "shards", "--shard", shard]);
    }
    assert!((8..=10).contains(&points(&desk, "shards").len()), "{}", points(&desk, "shards").len());
    desk.succeed(&["sweep", "space.ron", "--out", "shards"]);
    assert!(numbers(&desk, "shards") == whole);
}

#[test]
fn figures_are_those_of_replays_or_have_intervals() {
    let desk = desk();
    desk.succeed(&["sweep", "space.ron", "--out", "s"]);
    let mut table = csv::Reader::from_path(desk.path("s/space.csv")).unwrap();
    let column = |name: &str| table.headers().unwrap().iter().position(|head| head == name).unwrap();
    let [replayed, front, cycles, half] = ["replayed", "front", "cycles", "cycles_half_width"].map(column);
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert_eq!(rows.iter().filter(|row| &row[replayed] == "1").count(), 20);
    assert!(rows.len() > 60, "machines with and without culling");
    for row in &rows {
        assert!(row[cycles].parse::<f64>().unwrap() > 0.0, "{row:?}");
        assert_eq!(row[half].is_empty(), &row[replayed] == "1", "{row:?}");
        assert!(&row[front] == "0" || &row[replayed] == "1", "only what was replayed is on the front: {row:?}");
    }
    // A plan has the first set, and `check` both numbers.
    let plan = desk.succeed(&["sweep", "space.ron", "--plan", "-"]);
    assert!((9..=11).contains(&plan.lines().count()), "{plan}");
    assert_eq!(desk.succeed(&["check", "space.ron"]), "space.ron: a sweep file; 60 machines of a space, 20 replays\n");
}

#[test]
fn options_that_need_all_points_are_refused() {
    let desk = desk();
    for option in [&["--collect"][..], &["--emit", "slurm", "x.sh"]] {
        let output = desk.program(&[&["sweep", "space.ron", "--out", "s"], option].concat()).output().unwrap();
        let told = error_text(&output);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains("umbrasim sweep space.ron --shard I/N --out s"), "{told}");
    }
}
