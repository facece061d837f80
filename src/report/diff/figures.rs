//! Figures of two reports by their paths.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use crate::report::format::{ABSENT, change, exact, joules, or_absent, short, words};

/// Parts of a report that say how it was made; they are no results.
const ASIDE: [&str; 6] =
    ["schema", "frames", "pictures", "provenance", "wall_seconds", "simulated_rays_per_wall_second"];

/// Key figures of a run: the ends of their paths.
const KEY: [&str; 12] = [
    "milliseconds_per_frame",
    "rays_answered_per_second",
    "dram_bytes_per_frame",
    "dram_utilization",
    "joules_per_frame",
    "cycles",
    "shadow_rays_skipped",
    "traversal_saved.mean",
    "intersection_saved.mean",
    "occlusion_tests_per_pixel",
    "false_dark",
    "false_lit",
];

/// A figure in two reports.
#[derive(Serialize)]
pub(super) struct Figure {
    path: String,
    values: [Option<f64>; 2],
}

impl Figure {
    pub(super) fn differs(&self) -> bool {
        self.values[0] != self.values[1]
    }

    /// The figure's path in words.
    pub(super) fn name(&self) -> &str {
        &self.path
    }

    /// Its values in A and B.
    pub(super) fn values(&self) -> [Option<f64>; 2] {
        self.values
    }

    /// The change from A to B as a share of A's value; `None` if a value is missing, or A's is 0.
    pub(super) fn change(&self) -> Option<f64> {
        let [a, b] = self.values;
        a.zip(b).filter(|(a, _)| *a != 0.0).map(|(a, b)| b / a - 1.0)
    }

    /// The figure in words, both values, and the change.
    pub(super) fn row(&self) -> Vec<String> {
        let text: fn(f64) -> String = if self.path.ends_with(ENERGY) { joules } else { number };
        let show = |value: Option<f64>| or_absent(value, text);
        let [a, b] = self.values;
        let change = a.zip(b).and_then(|(a, b)| change(a, b));
        vec![self.path.clone(), show(a), show(b), change.unwrap_or_else(|| ABSENT.into())]
    }
}

/// The end of the path, in words, of the energy of a frame.
const ENERGY: &str = "energy/frame";

fn number(value: f64) -> String {
    let is_count = value.fract() == 0.0 && (0.0..1e7).contains(&value);
    match value {
        count if is_count => exact(count as u64),
        small if small.abs() < 0.001 => format!("{small:.3e}"),
        other => short(other),
    }
}

/// All figures, or the key figures of runs, that at least one of the two reports has.
pub(super) fn differences(a: &Value, b: &Value, all: bool) -> Vec<Figure> {
    let is_run = [a, b].iter().all(|report| report["policies"].is_object());
    let mut found: Vec<String> = Vec::new();
    let values = [a, b].map(|report| {
        let mut numbers = BTreeMap::new();
        collect(report, &mut Vec::new(), &mut |path, value| {
            if all || !is_run || is_key(path) {
                let path = told(path, is_run);
                found.push(path.clone());
                numbers.insert(path, value);
            }
        });
        numbers
    });
    let mut seen = std::collections::BTreeSet::new();
    found.retain(|path| seen.insert(path.clone()));
    let figure = |path: String| Figure { values: [0, 1].map(|at| values[at].get(&path).copied()), path };
    found.into_iter().map(figure).collect()
}

/// Calls `found` for each number.
fn collect<'a>(value: &'a Value, path: &mut Vec<String>, found: &mut impl FnMut(&[String], f64)) {
    let mut inside = |name: String, value: &'a Value, found: &mut _| {
        path.push(name);
        collect(value, path, found);
        path.pop();
    };
    match value {
        Value::Object(fields) => {
            let fields = fields.iter().filter(|(name, _)| !ASIDE.contains(&name.as_str()));
            fields.for_each(|(name, value)| inside(name.clone(), value, found));
        }
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(at, value)| inside(at.to_string(), value, found));
        }
        _ => {
            if let Some(value) = value.as_f64() {
                found(path, value);
            }
        }
    }
}

/// Whether a figure belongs to a policy, or to a policy on a machine, and is among [`KEY`].
fn is_key(path: &[String]) -> bool {
    let depth = match path.first().map(String::as_str) {
        Some("policies") => 2,
        Some("machines") if path.get(2).is_some_and(|part| part == "policies") => 4,
        _ => return false,
    };
    path.len() > depth && KEY.contains(&path[depth..].join(".").as_str())
}

/// The path in words: the policy or machine, then the figure.
fn told(path: &[String], is_run: bool) -> String {
    if !is_run {
        return path.join(".");
    }
    match path {
        [first, policy, rest @ ..] if first == "policies" => format!("{policy}: {}", of(rest)),
        [first, machine, part, policy, rest @ ..] if first == "machines" && part == "policies" => {
            format!("{machine}, {policy}: {}", of(rest))
        }
        path => path.join("."),
    }
}

fn of(rest: &[String]) -> String {
    words(&rest.join(" "))
        .replace("milliseconds per frame", "ms/frame")
        .replace("bytes per frame", "bytes/frame")
        .replace("joules per frame", ENERGY)
        .replace("rays answered per second", "rays answered/s")
        .replace("occlusion tests per pixel", "occlusion tests/pixel")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn figures_are_told_with_their_change_and_times_of_the_run_are_not() {
        let report = |ms: f64, wrong: u32| {
            json!({
                "policies": { "P": { "false_lit": wrong, "frames": [1] } },
                "machines": { "small": { "policies": { "P": { "milliseconds_per_frame": ms, "unit": { "x": ms } } } } },
                "wall_seconds": { "total": ms },
            })
        };
        let rows = |all| -> Vec<_> {
            let found = differences(&report(2.0, 3), &report(1.0, 3), all);
            found.iter().filter(|figure| figure.differs()).map(Figure::row).collect()
        };
        assert_eq!(rows(false), [["small, P: ms/frame", "2", "1", "\u{2212}50.0 %"]]);
        assert_eq!(rows(true).len(), 2);
        let none = differences(&report(2.0, 3), &json!({ "policies": {} }), false);
        assert_eq!(none[0].row(), ["P: false lit", "3", ABSENT, ABSENT]);
    }
}
