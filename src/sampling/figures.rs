//! The counters of [`MachineStats`] as named numbers, which can be subtracted and scaled.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::stats::MachineStats;

/// Figures by name.
pub(crate) type Figures = BTreeMap<String, f64>;

/// Fields that are no counters of the run.
const FIXED: [&str; 7] = ["unit_counts", "bounds", "oracle", "accuracy", "half_widths", "needs", "most"];

/// All counters by their path in a report: `bytes.l2.node`.
pub(crate) fn of(stats: &MachineStats) -> BTreeMap<String, f64> {
    let mut figures = BTreeMap::new();
    let value = serde_json::to_value(stats).expect("statistics are plain data, which JSON can hold");
    collect("", &value, &mut figures);
    figures
}

fn collect(path: &str, value: &Value, figures: &mut BTreeMap<String, f64>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields.iter().filter(|(name, _)| !FIXED.contains(&name.as_str())) {
                collect(&if path.is_empty() { name.clone() } else { format!("{path}.{name}") }, value, figures);
            }
        }
        Value::Number(number) => {
            if let Some(number) = number.as_u64() {
                figures.insert(path.to_owned(), number as f64);
            }
        }
        _ => {}
    }
}

/// `stats` with other counters.
pub(crate) fn with<'a>(stats: &MachineStats, figures: impl Iterator<Item = (&'a String, &'a f64)>) -> MachineStats {
    let mut value = serde_json::to_value(stats).expect("statistics are plain data, which JSON can hold");
    for (path, figure) in figures {
        let mut place = &mut value;
        for name in path.split('.') {
            place = &mut place[name];
        }
        *place = Value::from(figure.max(0.0).round() as u64);
    }
    serde_json::from_value(value).expect("the same fields")
}

/// What came between `before` and `after`.
pub(crate) fn difference(after: &BTreeMap<String, f64>, before: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    after.iter().map(|(name, value)| (name.clone(), value - before.get(name).copied().unwrap_or(0.0))).collect()
}
