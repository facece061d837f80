//! Tests that the rows hold the numbers of the summary, and that frames sum up to totals.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use super::{Results, files};
use crate::report::read_numbers;
use crate::report::replay::ReplaySummary;
use crate::report::reuse::ReuseSummary;
use crate::report::run::tests::sample::{sample, space, sweep};
use crate::report::run::{Summary, read_summary};
use crate::report::sweep::Change;
use crate::stats::{MachineStats, ReuseCurve, ReuseLevel, TrafficClass};

/// A CSV file's rows by header.
fn rows(csv: &[u8]) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_reader(csv).deserialize().map(Result::unwrap).collect()
}

/// `results.csv` and its dictionary.
fn written(results: &impl Results) -> [Vec<BTreeMap<String, String>>; 2] {
    let files = files(results).unwrap();
    let read = |name: &str| rows(&files.iter().find(|(file, _)| file.to_str() == Some(name)).unwrap().1);
    [read("results.csv"), read("results.dictionary.csv")]
}

/// The shipped sample report, which is of a real run.
fn shipped() -> (Summary, Value) {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/reports/sample/summary.json"));
    (read_summary(path).unwrap(), read_numbers(path).unwrap())
}

/// The numbers below a value, without those that tell the frame or light of others, or how these were estimated.
fn numbers(value: &Value, found: &mut Vec<f64>) {
    const APART: [&str; 7] = ["frame", "light", "warmup", "half_widths", "within", "residuals", "choice"];
    match value {
        Value::Number(number) => found.push(number.as_f64().unwrap()),
        Value::Array(values) => values.iter().for_each(|value| numbers(value, found)),
        Value::Object(fields) => {
            let own = fields.iter().filter(|(name, _)| !APART.contains(&name.as_str()));
            own.for_each(|(_, value)| numbers(value, found));
        }
        _ => {}
    }
}

/// The statistics of an invented run.
fn stats() -> MachineStats {
    sample(&[0, 16]).summary.machines.get("small").unwrap().policies.get("published").unwrap().stats.clone()
}

fn replay() -> ReplaySummary {
    ReplaySummary::new("room", "published", "Event", &[("small", stats())].into_iter().collect())
}

/// A cache that misses half of its accesses at every size; the sample has a tenth of them.
fn profile() -> ReuseSummary {
    let misses = ReuseCurve::sizes().map(|_| 50.0).collect();
    let curve = ReuseCurve { accesses: 1000, sampled: 100.0, first_touches: 1.0, misses, misses_in_sets: 50.0 };
    let classes = [(TrafficClass::Node, curve)].into();
    let level = ReuseLevel { name: "l1_traversal".into(), caches: 4, bytes: 16384, ways: 4, classes };
    let [machine, scene, policy, of] = ["small", "room", "published", "all lines"].map(String::from);
    ReuseSummary { machine, scene, policy, of, stats: stats(), levels: vec![level] }
}

#[test]
fn levels_cases_and_cache_sizes_are_rows() {
    let [levels, _] = written(&crate::report::pareto::with_timings().0);
    let of = |level: &str| {
        let rows = levels.iter().filter(|row| row["fidelity"] == level && row["metric"] == "cycles");
        rows.map(|row| (row["policy"].as_str(), row["value"].as_str(), row["half_width"].as_str())).collect::<Vec<_>>()
    };
    assert_eq!(of("Event"), [("Off", "1000", "0"), ("A", "980", "0")]);
    assert_eq!(of("B"), [("Off", "1020", "51"), ("A", "1100", "55")]);
    let [cases, _] = written(&crate::report::stress::summary());
    let lit = |scope: &str| {
        let wrong = cases.iter().filter(|row| row["scope"] == scope && row["metric"] == "false_dark");
        wrong.filter(|row| row["policy"] == "Published").map(|row| row["value"].clone()).collect::<Vec<_>>()
    };
    assert_eq!((lit("total"), lit("frame")), (vec!["156".into()], vec!["0".into(), "78".into(), "78".into()]));
    let of_models = cases.iter().filter(|row| row["metric"] == "model.differs");
    let of_models: Vec<_> = of_models.map(|row| (row["fidelity"].as_str(), row["value"].as_str())).collect();
    assert_eq!(of_models, [("Cycle", "0"), ("Bound", "0.5")]);
    let effects = cases.iter().filter(|row| row["metric"].starts_with("effect."));
    let effects: Vec<_> = effects.map(|row| (&row["part"], &row["value"], &row["half_width"])).collect();
    assert!(effects.len() == 2 && effects.iter().all(|it| *it.0 == "partial: Sticky" && it.2 == "0.125"));
    let [sizes, _] = written(&profile());
    let misses = sizes.iter().filter(|row| row["cache.bytes"] == "16384" && row["metric"] == "caches.misses");
    assert_eq!(misses.map(|row| row["value"].as_str()).collect::<Vec<_>>(), ["500"]);
    let [machines, _] = written(&replay());
    assert!(machines.iter().any(|row| row["machine"] == "small" && row["scope"] == "frame" && row["metric"] == "rays"));
}

#[test]
fn every_number_of_policies_and_machines_is_a_row() {
    for (summary, value) in [shipped(), {
        let summary = sample(&[0, 16]).summary;
        let value = serde_json::to_value(&summary).unwrap();
        (summary, value)
    }] {
        let mut declared = Vec::new();
        numbers(&value["policies"], &mut declared);
        for (_, machine) in value["machines"].as_object().unwrap() {
            ["policies", "split"].iter().filter_map(|part| machine.get(part)).for_each(|it| numbers(it, &mut declared));
        }
        let [results, _] = written(&summary);
        let told = results.iter().filter(|row| !row["value"].is_empty());
        let values = told.map(|row| row["value"].parse::<f64>().unwrap());
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        declared.sort_by(f64::total_cmp);
        values.sort_by(f64::total_cmp);
        assert_eq!(values, declared);
    }
}

#[test]
fn measured_frames_sum_to_totals_and_classes_to_levels() {
    let (summary, _) = shipped();
    let [results, _] = written(&summary);
    let sum = |policy: &str, wanted: &[(&str, &str)]| -> u64 {
        let is_meant = |row: &&BTreeMap<String, String>| {
            row["policy"] == policy && wanted.iter().all(|(column, value)| row[*column] == *value)
        };
        results.iter().filter(is_meant).map(|row| row["value"].parse::<u64>().unwrap()).sum()
    };
    let mut warm = 0;
    for (name, machine) in summary.machines.iter() {
        for (policy, run) in machine.policies.iter() {
            let of = |scope, metric, part| {
                sum(policy, &[("machine", name), ("scope", scope), ("metric", metric), ("part", part)])
            };
            for scope in ["total", "frame"] {
                assert_eq!(of(scope, "cycles", ""), run.stats.cycles.0);
                for level in run.stats.bytes.keys() {
                    assert_eq!(of(scope, "bytes", level), run.stats.moved(level).0, "{scope} {level}");
                }
                for (unit, causes) in &run.stats.units {
                    assert_eq!(of(scope, "units", unit), causes.values().sum::<u64>(), "{scope} {unit}");
                }
                for (cache, classes) in &run.stats.caches {
                    let hits = classes.values().map(|cache| cache.counts.hits).sum::<u64>();
                    assert_eq!(of(scope, "caches.hits", cache), hits, "{scope} {cache}");
                }
            }
            warm += of("warmup", "cycles", "");
        }
    }
    assert!(warm > 0, "the shipped report has a frame that warms up");
    for (policy, found) in summary.policies.iter() {
        let of = |scope| sum(policy, &[("machine", ""), ("scope", scope), ("metric", "shadow_node_visits")]);
        assert_eq!([of("total"), of("frame")], [found.counts.shadow_node_visits; 2]);
    }
}

#[test]
fn columns_and_metrics_are_in_the_dictionary() {
    let check = |[results, dictionary]: [Vec<BTreeMap<String, String>>; 2]| {
        let names = |entry: &str| -> BTreeSet<String> {
            let of = dictionary.iter().filter(|row| row["entry"] == entry);
            of.map(|row| row["name"].clone()).collect()
        };
        assert_eq!(names("column"), results[0].keys().cloned().collect());
        assert_eq!(names("metric"), results.iter().map(|row| row["metric"].clone()).collect());
        let units: BTreeSet<_> = dictionary.iter().map(|row| (row["name"].clone(), row["unit"].clone())).collect();
        for row in &results {
            assert!(units.contains(&(row["metric"].clone(), row["unit"].clone())), "{row:?}");
        }
        assert!(dictionary.iter().all(|row| !row["meaning"].is_empty()));
    };
    check(written(&shipped().0));
    check(written(&sample(&[0, 16]).summary));
    check(written(&sweep()));
    check(written(&crate::report::pareto::with_timings().0));
    check(written(&crate::report::stress::summary()));
    check(written(&replay()));
    check(written(&profile()));
}

#[test]
fn what_is_absent_has_no_row_and_what_is_estimated_has_its_interval() {
    let [results, _] = written(&sample(&[0, 16]).summary);
    let metric = |name: &'static str| results.iter().filter(move |row| row["metric"] == name);
    // Decisions towards lights were not checked under `off`.
    let lights: BTreeSet<_> = metric("lights.false_lit").map(|row| (&row["policy"], &row["part"])).collect();
    assert_eq!(lights.len(), 3);
    assert!(metric("psnr.decibel").any(|row| row["value"] == "inf" && row["policy"] == "off"));
    let wide: BTreeSet<_> = metric("bytes").filter(|row| row["half_width"] == "9000000").collect();
    assert!(wide.iter().all(|row| row["part"] == "dram" && row["class"] == "node" && row["scope"] == "total"));
    assert_eq!(wide.len(), 6, "a machine and policy each");
    assert!(metric("cycles").all(|row| row["half_width"].is_empty()), "its interval is not known");
    assert!(metric("shadow_rays").all(|row| row["half_width"] == "0"), "a count");
    // A number that a sample cannot estimate is empty, with its reason; a known number has no reason.
    let of = |row: &BTreeMap<String, String>| ["value", "half_width", "reason"].map(|column| row[column].clone());
    let untold: BTreeSet<_> = metric("split.extra_misses").map(of).collect();
    assert_eq!(untold, BTreeSet::from([["", "", "the sample has no interval of this"].map(String::from)]));
    assert!(
        metric("split.saved").all(|row| row["half_width"].parse::<f64>().unwrap() > 0.0 && row["reason"].is_empty())
    );
    assert!(results.iter().all(|row| row["half_width"].is_empty() != row["reason"].is_empty()));
}

#[test]
fn a_sweep_has_a_column_a_varied_field() {
    let mut several = sweep();
    several.points[1].changes.push(Change { field: "clock_mhz".into(), value: "800".into() });
    let [results, _] = written(&several);
    let fields = |row: &BTreeMap<String, String>| ["shadow_cache.place", "clock_mhz"].map(|field| row[field].clone());
    let points: BTreeSet<_> = results.iter().map(fields).collect();
    assert_eq!(points, BTreeSet::from([["", ""], ["L2", "800"]].map(|point| point.map(String::from))));
    let bytes = |place: &str| -> Vec<_> {
        let meant = results.iter().filter(|row| row["metric"] == "bytes" && row["shadow_cache.place"] == place);
        meant.map(|row| (row["part"].as_str(), row["class"].as_str(), row["fidelity"].as_str())).collect()
    };
    assert!(bytes("L2").contains(&("dram", "node", "Event")));
    assert_eq!(bytes("L2"), bytes(""), "the machine's own value is absent");
    let replays = results.iter().filter(|row| row["metric"] == "split.cycles").map(|row| row["class"].as_str());
    assert_eq!(replays.collect::<BTreeSet<_>>(), BTreeSet::from(["as_it_is", "free_words", "without_culling"]));
}

#[test]
fn a_design_that_is_predicted_has_intervals() {
    let [results, _] = written(&space());
    let of = |metric: &str| -> Vec<_> {
        let meant = results.iter().filter(|row| row["metric"] == metric);
        meant.map(|row| (row["l2.bytes"].as_str(), row["fidelity"].as_str(), row["half_width"].as_str())).collect()
    };
    assert_eq!(of("cycles"), [("65536", "Event", "0"), ("131072", "predicted", "120")]);
    assert_eq!(of("wrong_pixels"), [("65536", "Event", "0"), ("131072", "predicted", "0")]);
}

#[cfg(feature = "parquet")]
#[test]
fn parquet_holds_the_same_rows() {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    for results in [files(&sample(&[0, 16]).summary).unwrap(), files(&sweep()).unwrap()] {
        let of = |name: &str| &results.iter().find(|(file, _)| file.to_str() == Some(name)).unwrap().1;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.parquet");
        std::fs::write(&path, of("results.parquet")).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let mut read = reader.get_row_iter(None).unwrap();
        let mut csv = csv::Reader::from_reader(of("results.csv").as_slice());
        let head = csv.headers().unwrap().clone();
        for row in csv.records() {
            let (row, found) = (row.unwrap(), read.next().unwrap().unwrap());
            for ((name, text), (column, field)) in head.iter().zip(&row).zip(found.get_column_iter()) {
                let same = match field {
                    Field::Null => text.is_empty(),
                    Field::Str(found) => found == text,
                    Field::Long(found) => text.parse() == Ok(*found),
                    Field::Double(found) => text.parse() == Ok(*found),
                    other => panic!("{other:?}"),
                };
                assert!(same && name == column, "{name}: {text} and {field:?}");
            }
            assert_eq!(found.len(), head.len());
        }
        assert!(read.next().is_none());
    }
}
