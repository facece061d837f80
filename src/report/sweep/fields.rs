//! The fields that a sweep varies, and the values of points along them.

use super::data::{Own, SweepPoint, SweepSummary};
use crate::size::amount;

/// A varied field.
pub(super) struct Field<'a> {
    /// Its path.
    pub path: &'a str,
    /// Its values: numbers in ascending order, other values in the order of the file.
    pub values: Vec<&'a str>,
}

/// All varied fields, in the order in which they first occur.
pub(super) fn fields(summary: &SweepSummary) -> Vec<Field<'_>> {
    let mut fields: Vec<Field<'_>> = Vec::new();
    for change in summary.points.iter().flat_map(|point| &point.changes) {
        let at = fields.iter().position(|field| field.path == change.field).unwrap_or_else(|| {
            fields.push(Field { path: &change.field, values: Vec::new() });
            fields.len() - 1
        });
        if !fields[at].values.contains(&change.value.as_str()) {
            fields[at].values.push(&change.value);
        }
    }
    for field in &mut fields {
        // A machine's own value counts as one of the sweep's if some point leaves the field unchanged.
        let kept = |own: &Own| {
            let left = |point: &SweepPoint| point.changes.iter().all(|change| change.field != own.field);
            summary.points.iter().any(|point| point.machine == own.machine && left(point))
        };
        for own in summary.own.iter().filter(|own| own.field == field.path && kept(own)) {
            if !field.values.contains(&own.value.as_str()) {
                field.values.insert(0, &own.value);
            }
        }
        if field.values.iter().all(|value| amount(value).is_some()) {
            field.values.sort_by(|a, b| amount(a).unwrap_or(0.0).total_cmp(&amount(b).unwrap_or(0.0)));
        }
    }
    fields
}

/// The value of a field at a point: the changed value, or the machine's own.
pub(super) fn value<'a>(summary: &'a SweepSummary, point: &'a SweepPoint, field: &str) -> Option<&'a str> {
    let set = point.changes.iter().find(|change| change.field == field).map(|change| change.value.as_str());
    set.or_else(|| own(summary, &point.machine, field))
}

/// The value of a field in a machine's file.
pub(super) fn own<'a>(summary: &'a SweepSummary, machine: &str, field: &str) -> Option<&'a str> {
    summary.own.iter().find(|own| own.machine == machine && own.field == field).map(|own| own.value.as_str())
}

/// Places of values along an axis from 0 to 1: numbers on a logarithmic scale if all are above zero, other values at
/// equal distances.
pub(super) fn places(values: &[&str]) -> Vec<f64> {
    let numbers: Option<Vec<f64>> = values.iter().map(|value| amount(value)).collect();
    let numbers = numbers.filter(|all| all.iter().all(|&number| number > 0.0));
    let (Some(numbers), true) = (numbers, values.len() > 1) else {
        let last = (values.len().max(2) - 1) as f64;
        return (0..values.len()).map(|place| place as f64 / last).collect();
    };
    let (least, most) =
        numbers.iter().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), &it| (low.min(it), high.max(it)));
    numbers.iter().map(|number| (number / least).ln() / (most / least).ln().max(1e-9)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lie_on_a_logarithmic_axis() {
        assert_eq!(places(&["1", "4", "16"]), [0.0, 0.5, 1.0]);
        assert_eq!(places(&["A", "B", "C"]), [0.0, 0.5, 1.0]);
        assert_eq!(places(&["A"]), [0.0]);
    }
}
