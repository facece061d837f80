//! The meaning of every number of a report, for `umbrasim explain`: counters from their declarations, others from a
//! table.

mod declared;

use serde_json::Value;

use crate::counters::Counter;
use crate::report::grid::{Grid, drawn};
use crate::stats::{CacheCounts, DramCounts, L1Counts, LatencyCounts, QueueCounts};
use crate::stream::Totals;

/// A number of `summary.json`, or a column of `frames.csv`.
#[derive(Clone, Debug)]
pub struct Statistic {
    /// Its path in `summary.json`; `*` stands for a name in the experiment, a part of the machine, or a class of
    /// traffic. A declaration of a policy's number holds for all its frames together and for each frame
    /// (`policies.*.frames.*`). A declaration of what a policy saved and paid on a machine (`machines.*.split.*`)
    /// holds for each point of a sweep too (`points.*`).
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub about: &'static str,
}

/// The counters of a report by the path of their group; the code that counts declares them.
const COUNTERS: &[(&str, &[Counter])] = &[
    ("policies.*", Totals::DECLARED),
    ("machines.*.policies.*.caches.*.*", CacheCounts::DECLARED),
    ("machines.*.policies.*.caches.*.*", L1Counts::DECLARED),
    ("machines.*.policies.*.queues.*", QueueCounts::DECLARED),
    ("machines.*.policies.*.latency.*", LatencyCounts::DECLARED),
    ("machines.*.policies.*.dram", DramCounts::DECLARED),
    ("machines.*.policies.*.frames.*.caches.*", CacheCounts::DECLARED),
    ("machines.*.policies.*.frames.*.dram", DramCounts::DECLARED),
];

/// All numbers of a report.
pub fn statistics() -> Vec<Statistic> {
    let others = declared::OTHERS.iter().map(|&(name, unit, about)| Statistic { name: name.to_owned(), unit, about });
    let counters = COUNTERS.iter().flat_map(|&(path, counters)| counters.iter().map(move |counter| (path, counter)));
    let counters = counters.map(|(path, &Counter { name, unit, about })| Statistic {
        name: format!("{path}.{name}"),
        unit,
        about,
    });
    counters.chain(others).collect()
}

/// Collects the numbers of a summary, each with its path.
fn numbers(value: &Value, path: &mut Vec<String>, found: &mut Vec<(Vec<String>, String)>) {
    let mut below = |name: String, value: &Value| {
        path.push(name);
        numbers(value, path, found);
        path.pop();
    };
    match value {
        Value::Number(number) => found.push((path.clone(), number.to_string())),
        Value::Array(values) => values.iter().enumerate().for_each(|(index, value)| below(index.to_string(), value)),
        Value::Object(fields) => fields.iter().for_each(|(name, value)| below(name.clone(), value)),
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

impl Statistic {
    fn parts(&self) -> impl DoubleEndedIterator<Item = &str> {
        self.name.split('.')
    }

    /// Whether this is the declaration of the number at `path`.
    fn declares(&self, path: &[String]) -> bool {
        let (mut own, mut path) = (self.name.as_str(), path);
        if let (Some(of_split), [points, _, of_point @ ..]) = (own.strip_prefix("machines.*.split.*."), path)
            && points == "points"
        {
            (own, path) = (of_split, of_point);
        }
        let one_frame = path.len() > 4 && path[0] == "policies" && path[2] == "frames";
        let skipped = if one_frame { 2..4 } else { 0..0 };
        let mut path = path.iter().enumerate().filter(|(index, _)| !skipped.contains(index)).map(|(_, part)| part);
        own.split('.').all(|part| path.next().is_some_and(|found| part == "*" || part == found))
            && path.next().is_none()
    }

    /// The words of `name` in places where this statistic's path has `*`.
    fn named<'a>(&self, name: &'a str) -> Vec<&'a str> {
        let asked: Vec<_> = name.split('.').collect();
        let own: Vec<_> = self.parts().collect();
        let own = own.iter().rev().zip(asked.iter().rev());
        own.filter(|(own, asked)| **own == "*" && **asked != "*").map(|(_, asked)| *asked).collect()
    }

    /// Whether `name`, a path or the end of one, refers to this statistic.
    fn is_meant(&self, name: &str) -> bool {
        let asked: Vec<_> = name.split('.').collect();
        let own: Vec<_> = self.parts().collect();
        let Some(skipped) = own.len().checked_sub(asked.len()) else { return false };
        own[skipped] == asked[0] && own[skipped..].iter().zip(&asked).all(|(own, asked)| *own == "*" || own == asked)
    }
}

/// The numbers of a `summary.json` without a declaration, or with several.
pub fn undeclared(summary: &Value) -> Vec<String> {
    let mut found = Vec::new();
    numbers(summary, &mut Vec::new(), &mut found);
    let statistics = statistics();
    let declarations = |path: &[String]| statistics.iter().filter(|statistic| statistic.declares(path)).count();
    found.into_iter().filter(|(path, _)| declarations(path) != 1).map(|(path, _)| path.join(".")).collect()
}

/// The number of the frame to which the number at `path` belongs, and whether that frame is warm-up; empty if it
/// belongs to no frame. The path holds the frame's index in the list, which differs from its number.
fn frame(report: &Value, path: &[String]) -> String {
    let of_path = || {
        let at = path.iter().position(|part| part == "frames")?;
        let frame = path.get(..=at + 1)?.iter().try_fold(report, |value, part| match value {
            Value::Array(values) => values.get(part.parse::<usize>().ok()?),
            value => value.get(part),
        })?;
        let warms_up = frame.get("warmup").and_then(Value::as_bool).unwrap_or_default();
        Some(format!("{}{}", frame.get("frame")?, if warms_up { ", warm-up" } else { "" }))
    };
    of_path().unwrap_or_default()
}

/// Explains the statistics whose paths end with `name`, or all; adds their values in `report`, if there is one.
///
/// # Errors
/// No statistic has this name; the error lists similar names.
pub fn explain(name: Option<&str>, report: Option<&Value>) -> Result<String, String> {
    let meant = |statistic: &&Statistic| name.is_none_or(|name| statistic.is_meant(name));
    let statistics = statistics();
    let meant: Vec<_> = statistics.iter().filter(meant).collect();
    if meant.is_empty() {
        let name = name.unwrap_or_default();
        let names = statistics.iter().map(|statistic| statistic.name.as_str());
        let similar: Vec<_> = names.filter(|it| it.contains(name)).collect();
        let hint = if similar.is_empty() { String::new() } else { format!("; there are {}", similar.join(", ")) };
        return Err(format!("no statistic is called `{name}`{hint} (`umbrasim explain` lists all)"));
    }
    let heads = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let row = |it: &&Statistic| vec![it.name.clone(), it.unit.to_owned(), it.about.to_owned()];
    let about =
        Grid { head: heads(&["statistic", "unit", "what it is"]), names: 3, rows: meant.iter().map(row).collect() };
    let Some(report) = report else { return Ok(drawn(&about)) };
    let mut found = Vec::new();
    numbers(report, &mut Vec::new(), &mut found);
    let is_meant = |statistic: &Statistic, path: &[String]| {
        let named = name.map(|name| statistic.named(name)).unwrap_or_default();
        statistic.declares(path) && named.iter().all(|word| path.iter().any(|part| part == word))
    };
    let of_meant = found.into_iter().filter(|(path, _)| meant.iter().any(|statistic| is_meant(statistic, path)));
    let row = |(path, number): (Vec<String>, String)| vec![path.join("."), frame(report, &path), number];
    let mut values =
        Grid { head: heads(&["in the report", "frame", "value"]), names: 2, rows: of_meant.map(row).collect() };
    if values.rows.iter().all(|row| row[1].is_empty()) {
        values.head.remove(1);
        values.rows.iter_mut().for_each(|row| _ = row.remove(1));
        values.names = 1;
    }
    Ok(format!("{}\n\n{}", drawn(&about), drawn(&values)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::frames_csv::frames_csv;

    #[test]
    fn every_number_of_a_report_is_declared_once_and_every_declaration_is_of_one() {
        let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/reports/sample");
        let text = std::fs::read_to_string(format!("{sample}/summary.json")).unwrap();
        let summary = serde_json::from_str(&text).unwrap();
        assert_eq!(undeclared(&summary), Vec::<String>::new());
        let mut found = Vec::new();
        numbers(&summary, &mut Vec::new(), &mut found);
        // The shipped sample is of an exact fidelity level; the sample for tests adds the numbers of estimates.
        let estimated = crate::report::run::tests::sample::sample(&[0]).summary;
        let of_machines = frames_csv(&estimated).head;
        let estimated = serde_json::to_value(estimated).unwrap();
        assert_eq!(undeclared(&estimated), Vec::<String>::new());
        numbers(&estimated, &mut Vec::new(), &mut found);
        let sweep = serde_json::to_value(crate::report::run::tests::sample::sweep()).unwrap();
        assert_eq!(undeclared(&sweep), Vec::<String>::new());
        numbers(&sweep, &mut Vec::new(), &mut found);
        let space = serde_json::to_value(crate::report::run::tests::sample::space()).unwrap();
        assert_eq!(undeclared(&space), Vec::<String>::new());
        numbers(&space, &mut Vec::new(), &mut found);
        let stress = serde_json::to_value(crate::report::stress::summary()).unwrap();
        assert_eq!(undeclared(&stress), Vec::<String>::new());
        numbers(&stress, &mut Vec::new(), &mut found);
        let csv = std::fs::read_to_string(format!("{sample}/frames.csv")).unwrap();
        let statistics = statistics();
        let columns: Vec<_> =
            csv.lines().next().unwrap().split(',').skip(1).map(|name| format!("policies.*.{name}")).collect();
        // The column of a machine has the name of the summary's number.
        let of_machine = |name: &str| {
            let (machine, path) = name.split_once('.').unwrap();
            let path = format!("machines.{machine}.policies.off.frames.0.{path}");
            path.split('.').map(str::to_owned).collect::<Vec<_>>()
        };
        for path in of_machines.iter().filter(|name| name.contains('.')).map(|name| of_machine(name)) {
            assert!(statistics.iter().any(|statistic| statistic.declares(&path)), "{path:?}");
            found.push((path, String::new()));
        }
        for column in columns.iter().filter(|name| name.matches('.').count() == 2) {
            assert!(statistics.iter().any(|statistic| statistic.name == *column), "{column}");
        }
        for statistic in &statistics {
            let is_there = found.iter().any(|(path, _)| statistic.declares(path)) || columns.contains(&statistic.name);
            assert!(is_there, "{} is declared, and no number is called so", statistic.name);
        }
    }

    #[test]
    fn values_are_those_of_the_names_that_were_asked_for() {
        let report = serde_json::json!({ "machines": { "small": { "policies": { "Off": {
            "bytes": { "dram": { "node": 1, "ray": 2 }, "l2": { "node": 3 } }, "cycles": 4,
        } } } } });
        let values = |name: &str| {
            let told = explain(Some(name), Some(&report)).unwrap();
            let lines = told.lines().filter(|line| line.starts_with("machines.small."));
            lines.map(|line| line.split_whitespace().last().unwrap().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(values("bytes.dram.node"), ["1"]);
        assert_eq!(values("bytes.*.node"), ["1", "3"]);
        assert_eq!(values("machines.small.policies.Off.cycles"), ["4"]);
        assert_eq!(values("bytes.*.*"), ["1", "2", "3"]);
    }

    /// A frame's index in the list differs from its number.
    #[test]
    fn values_of_frames_have_their_frames() {
        let frame = |number: u32, warmup: bool| {
            let dram = serde_json::json!({ "row_hits": number + 1 });
            serde_json::json!({ "frame": number, "warmup": warmup, "dram": dram })
        };
        let report = serde_json::json!({ "machines": { "small": { "policies": { "Off": {
            "dram": { "row_hits": 7 }, "frames": [frame(0, true), frame(4, false)],
        } } } } });
        let told = explain(Some("row_hits"), Some(&report)).unwrap();
        let lines = told.lines().filter(|line| line.starts_with("machines.small."));
        let values: Vec<_> = lines.map(|line| line.split_whitespace().skip(1).collect::<Vec<_>>().join(" ")).collect();
        assert_eq!(values, ["7", "0, warm-up 1", "4 5"]);
    }

    #[test]
    fn a_name_means_what_ends_with_it() {
        let names = |asked: &str| {
            let meant = statistics().into_iter().filter(|statistic| statistic.is_meant(asked));
            meant.map(|statistic| statistic.name).collect::<Vec<_>>()
        };
        let row_hits = ["machines.*.policies.*.dram.row_hits", "machines.*.policies.*.frames.*.dram.row_hits"];
        assert_eq!(names("row_hits"), row_hits);
        assert_eq!(names("bytes.dram.mode_word"), ["machines.*.policies.*.bytes.*.*"]);
        let of_stress = "cases.*.policies.*.*.false_dark";
        assert_eq!(names("false_dark"), ["policies.*.false_dark", "policies.*.lights.*.false_dark", of_stress]);
        let error = explain(Some("row_hit"), None).unwrap_err();
        assert!(error.contains("`row_hit`; there are machines.*.policies.*.dram.row_hits"), "{error}");
    }
}
