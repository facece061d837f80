//! Tables of the book that are made from CSV files beside it: their figures are those of the files.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

type Row = BTreeMap<String, String>;

fn page(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name)).unwrap()
}

/// The rows of a file of the study, those without culling left out.
fn rows(name: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/validation/study/{name}.csv"));
    let rows: Vec<Row> = csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect();
    let culling: Vec<Row> = rows.into_iter().filter(|row| row["policy"] != "Off").collect();
    assert!(culling.len() > 5, "{name} has hardly any rows");
    culling
}

/// The row of these values.
fn find<'a>(rows: &'a [Row], wanted: &[(&str, &str)]) -> &'a Row {
    let is = |row: &&Row| wanted.iter().all(|(column, value)| row[*column] == *value);
    rows.iter().find(is).unwrap_or_else(|| panic!("no row is {wanted:?}"))
}

/// Shares as cells of a table, each with its sign and one digit.
fn cells(shares: &[&str]) -> String {
    let cell = |share: &&str| format!("{:+.1} %", 100.0 * share.parse::<f64>().unwrap());
    shares.iter().map(cell).collect::<Vec<_>>().join(" | ").replace("-0.0 %", "+0.0 %")
}

/// Whether a table of the page has these cells beside each other.
fn has(page: &str, cells: &str) -> bool {
    page.lines().any(|line| line.replace("-0.0 %", "+0.0 %").replace("| 0.0 %", "| +0.0 %").contains(cells))
}

const DESIGN: [&str; 4] = ["cycles_change", "cold_change", "dram_change", "joules_change"];

#[test]
fn designs_of_the_unit_are_those_of_their_files() {
    let page = page("model/shadow_cache_unit.md");
    for scene in ["kitchen", "robot"] {
        for row in rows(&format!("unit_designs_{scene}")) {
            let cells = cells(&DESIGN.map(|column| row[column].as_str()));
            assert!(has(&page, &cells), "{scene}, {} {} {}: {cells}", row["machine"], row["policy"], row["design"]);
        }
    }
}

#[test]
fn the_studys_scenes_are_those_of_their_files() {
    let page = page("validation/study.md");
    for (scene, file) in [
        ("kitchen", "unit_designs_kitchen"),
        ("robot", "unit_designs_robot"),
        ("living room", "designs_living_room"),
        ("staircase", "designs_staircase"),
        ("Sponza", "designs_sponza"),
        ("gas station", "designs_gas_station"),
    ] {
        let rows = rows(file);
        for machine in ["desktop", "small"] {
            for (policy, design) in
                [("Published", "fair: the same and `gather: 128`"), ("Hybrid", "four of those units")]
            {
                let of = |design| find(&rows, &[("machine", machine), ("policy", policy), ("design", design)]);
                let (own, free) = (of(design), of("free words"));
                let figures = cells(&[
                    &own["cycles_change"],
                    &own["cold_change"],
                    &free["cycles_change"],
                    &own["dram_change"],
                    &own["joules_change"],
                    &free["joules_change"],
                ]);
                let line = format!("| {scene} | `{machine}` | `{policy}` | {figures} |");
                assert!(has(&page, &line), "{line}");
            }
        }
    }
}

#[test]
fn the_studys_words_and_lights_are_those_of_their_files() {
    let page = page("validation/study.md");
    let words = rows("words");
    for row in words.iter().filter(|row| row["machine"] == "desktop") {
        let small = find(&words, &[("scene", &row["scene"]), ("machine", "small"), ("design", &row["design"])]);
        let figures = cells(&[
            &row["cycles_change"],
            &row["cold_change"],
            &small["cycles_change"],
            &small["cold_change"],
            &small["dram_change"],
        ]);
        assert!(has(&page, &figures), "{}: {figures}", row["design"]);
    }
    let lights = rows("lights");
    for row in lights.iter().filter(|row| row["policy"] == "Published" && row["design"] == "as it is") {
        let scene = ("scene", row["scene"].as_str());
        let same = [scene, ("lights", &row["lights"]), ("machine", &row["machine"]), ("policy", "Published")];
        let free = find(&lights, &[&same[..], &[("design", "free words")]].concat());
        let figures = cells(&[
            &row["cycles_change"],
            &row["cold_change"],
            &free["cycles_change"],
            &row["dram_change"],
            &row["joules_change"],
        ]);
        let scene = row["scene"].replace('_', " ");
        let line = format!("| {scene} | {} | `{}` | {figures} |", row["lights"], row["machine"]);
        assert!(has(&page, &line), "{line}");
    }
}

#[test]
fn the_balance_of_machines_is_that_of_its_file() {
    let page = page("model/machines.md");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/validation/study/balance.csv");
    let rows: Vec<Row> = csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect();
    for row in rows {
        let share = |unit: &str| format!("{:.1} %", 100.0 * row[unit].parse::<f64>().unwrap());
        let shares = ["dispatcher", "traversal", "intersection", "division", "dram"].map(share).join(" | ");
        let scene = row["scene"].replace('_', " ").replace("sponza", "Sponza");
        assert!(has(&page, &format!("| {scene} | `{}` | {shares} |", row["machine"])), "{row:?}");
    }
}

#[test]
fn wrong_decisions_of_the_study_are_those_of_their_file() {
    let page = page("validation/study.md");
    for row in rows("wrong") {
        let count = |name: &str| row[name].parse::<f64>().unwrap();
        let wrong = count("false_dark") + count("false_lit");
        if row["policy"] == "Hybrid" {
            assert!(wrong == 0.0, "{row:?}");
            continue;
        }
        let scene = row["scene"].replace('_', " ").replace("sponza", "Sponza");
        let start = format!("| {scene} | {0}x{0} | ", row["resolution"]);
        let line = page.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("no line {start}"));
        let cells: Vec<String> = line.split(" | ").map(|cell| cell.replace(',', "")).collect();
        let a_million = format!("{:.0}", 1e6 * wrong / count("compared_rays"));
        let file = ["compared_rays", "false_dark", "false_lit"].map(|name| row[name].clone());
        assert_eq!((&cells[2..5], &cells[5]), (&file[..], &a_million), "{line}");
    }
}
