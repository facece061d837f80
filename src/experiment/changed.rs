//! Finds the fields of an experiment's machines and tracer that differ from their defaults.

use serde::Serialize;
use serde_json::Value;

use super::load::Experiment;
use crate::json;
use crate::machine::MachineSpec;
use crate::tracer::TracerSpec;

/// Paths of the fields, as in the configuration as run: `machines.small.clock_mhz`.
pub(super) fn changed(experiment: &Experiment) -> Vec<String> {
    let mut paths = Vec::new();
    compare("experiment.tracer", &value(&experiment.spec.tracer), &value(&TracerSpec::default()), &mut paths);
    for (name, machine) in experiment.machines.iter() {
        let path = format!("machines.{name}");
        compare(&path, &value(machine), &value(&MachineSpec::default()), &mut paths);
    }
    paths
}

fn value(spec: &impl Serialize) -> Value {
    json::value(spec).expect("specs are plain data, which JSON can hold")
}

/// Adds the paths of all leaves that differ.
fn compare(path: &str, found: &Value, default: &Value, paths: &mut Vec<String>) {
    match (found, default) {
        (Value::Object(fields), Value::Object(others)) => {
            for (name, field) in fields {
                compare(&format!("{path}.{name}"), field, others.get(name).unwrap_or(&Value::Null), paths);
            }
        }
        _ if found != default => paths.push(path.to_owned()),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn leaves_that_differ_are_named() {
        let [found, default] = [json!({"a": 1, "b": {"c": 2, "d": [1]}}), json!({"a": 1, "b": {"c": 3, "d": [2]}})];
        let mut paths = Vec::new();
        compare("m", &found, &default, &mut paths);
        assert_eq!(paths, ["m.b.c", "m.b.d"]);
    }
}
