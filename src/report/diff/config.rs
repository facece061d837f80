//! Experiments as run, field by field.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use crate::input::{self, MAX_CONFIG_BYTES};
use crate::report::error::ReportError;
use crate::report::format::{ABSENT, counted};

/// The experiment as run, in the report's folder.
const CONFIG_FILE: &str = "config.ron";

/// Values by the paths of their fields.
pub(super) type Fields = BTreeMap<String, String>;

/// The fields of the experiment in the report `folder`; empty if the folder holds no config.
pub(super) fn read(folder: &Path) -> Result<Fields, ReportError> {
    let path = folder.join(CONFIG_FILE);
    match input::read_text(&path, MAX_CONFIG_BYTES) {
        Ok(text) => Ok(fields(&text)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Fields::new()),
        Err(source) => Err(ReportError::Read { path, source }),
    }
}

/// Splits a config that the program wrote into fields. Each line holds a field, a name or a list item; the content of
/// brackets is on lines of its own.
fn fields(text: &str) -> Fields {
    let mut found = Fields::new();
    // Names of the open brackets, and the number of items that each has had.
    let mut open: Vec<(String, usize)> = Vec::new();
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let line = line.trim_end_matches(',');
        if line.chars().all(|letter| ")]}".contains(letter)) {
            line.chars().for_each(|_| drop(open.pop()));
            continue;
        }
        let (name, value) = match line.split_once(": ") {
            Some((name, value)) => (name.trim_matches('"').to_owned(), value),
            None => {
                let item = open.last_mut().map_or(0, |(_, items)| {
                    *items += 1;
                    *items - 1
                });
                (item.to_string(), line)
            }
        };
        let brackets = value.chars().rev().take_while(|letter| "([{".contains(*letter)).count();
        let before = value[..value.len() - brackets].to_owned();
        if brackets == 0 {
            found.insert(path(&open, &name), value.to_owned());
            continue;
        }
        if !before.is_empty() {
            found.insert(path(&open, &name), before.replace('(', " "));
        }
        open.push((name, 0));
        // Inner brackets on the same line have no names.
        (1..value.chars().filter(|letter| "([{".contains(*letter)).count()).for_each(|_| open.push((String::new(), 0)));
    }
    found
}

fn path(open: &[(String, usize)], name: &str) -> String {
    // The outermost brackets have no name of their own.
    let outer = open.iter().skip(1).map(|(name, _)| name.as_str());
    outer.chain([name]).filter(|name| !name.is_empty()).collect::<Vec<_>>().join(".")
}

/// Fields whose values differ, with both values; a missing field is shown as absent. A part that only one config has,
/// such as a machine, is one row.
pub(super) fn differences(a: &Fields, b: &Fields) -> Vec<[String; 3]> {
    let paths: BTreeSet<&str> = a.keys().chain(b.keys()).map(String::as_str).collect();
    let whole: BTreeSet<&str> = paths.into_iter().map(|path| whole(a, b, path)).collect();
    let rows = whole.into_iter().map(|path| [path.to_owned(), value(a, path), value(b, path)]);
    rows.filter(|[_, a, b]| a != b).collect()
}

/// The outermost part of `path` that only one config has, or `path` itself.
fn whole<'a>(a: &Fields, b: &Fields, path: &'a str) -> &'a str {
    let ends = path.match_indices('.').map(|(end, _)| &path[..end]);
    let is_apart = |part: &&str| (count(a, part) == 0) != (count(b, part) == 0);
    ends.into_iter().find(is_apart).unwrap_or(path)
}

/// Number of fields in `part`.
fn count(fields: &Fields, part: &str) -> usize {
    let inside = fields.range(part.to_owned()..).take_while(|(path, _)| path.starts_with(part));
    inside.filter(|(path, _)| path.len() == part.len() || path[part.len()..].starts_with('.')).count()
}

/// The value of a field, or the number of fields in a part.
fn value(fields: &Fields, path: &str) -> String {
    match (fields.get(path), count(fields, path)) {
        (Some(value), _) => value.clone(),
        (None, 0) => ABSENT.into(),
        (None, count) => counted(count, "field"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_have_the_paths_that_they_have_in_the_file() {
        let text = "#![enable(x)]\n(\n    experiment: (\n        name: \"a\",\n        policies: {\n            \"Off\": Off,\n            \
                    \"P\": Published(\n                preset: Sensible,\n            ),\n        },\n        machines: [\n            \"x\",\n            \
                    \"y\",\n        ],\n    ),\n    scene: BuiltIn(Room(\n        lights: 4,\n    )),\n    last: 1,\n)\n";
        let found = fields(text);
        let expected = [
            ("experiment.machines.0", "\"x\""),
            ("experiment.machines.1", "\"y\""),
            ("experiment.name", "\"a\""),
            ("experiment.policies.Off", "Off"),
            ("experiment.policies.P", "Published"),
            ("experiment.policies.P.preset", "Sensible"),
            ("last", "1"),
            ("scene", "BuiltIn Room"),
            ("scene.lights", "4"),
        ];
        let found: Vec<_> = found.iter().map(|(path, value)| (path.as_str(), value.as_str())).collect();
        assert_eq!(found, expected);
        let other = fields(&text.replace("lights: 4", "lights: 5").replace("last: 1", "next: 1"));
        let rows = differences(&fields(text), &other);
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[2], ["scene.lights", "4", "5"]);
        let more = text.replace("\"P\": Pub", "\"Q\": Other(\n a: 1,\n b: 2,\n),\n\"P\": Pub");
        assert_eq!(differences(&fields(text), &fields(&more)), [["experiment.policies.Q", ABSENT, "Other"]]);
    }
}
