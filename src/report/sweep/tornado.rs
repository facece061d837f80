//! How far each of many fields moves cycles: a bar from its best to its worst value.

use super::data::{SweepPoint, SweepSummary};
use super::fields::{Field, fields, value};
use super::values::shown;
use crate::report::draw::reach::{Reach, reaches};
use crate::report::draw::{Figure, Plot};
use crate::report::format::signed;

/// Fewer fields are told by curves or a map.
const MANY: usize = 3;

pub(super) const PLOT: Plot<SweepSummary> = Plot { name: "sensitivity", section: (), figure };

/// Mean cycles of points with each value, over those of the machine as it is, or of all points if that was not tried.
fn reach(summary: &SweepSummary, points: &[&SweepPoint], field: &Field<'_>) -> Option<Reach> {
    let cycles = |points: &[&SweepPoint]| {
        let sum: f64 = points.iter().map(|point| point.split.cycles[2] as f64).sum();
        (!points.is_empty() && sum > 0.0).then(|| sum / points.len() as f64)
    };
    let single = points.iter().all(|point| point.changes.len() < 2);
    let own: Vec<_> = points.iter().copied().filter(|point| point.changes.is_empty()).collect();
    let reference = cycles(&own).or_else(|| cycles(points))?;
    let varies = |point: &SweepPoint| !single || point.changes.iter().all(|change| change.field == field.path);
    let of_value = |wanted: &&str| {
        let with: Vec<_> = points
            .iter()
            .copied()
            .filter(|point| varies(point) && value(summary, point, field.path) == Some(wanted))
            .collect();
        Some((shown(field.path, wanted), cycles(&with)? / reference - 1.0))
    };
    let all: Vec<(String, f64)> = field.values.iter().filter_map(of_value).collect();
    Some(Reach {
        field: field.path.to_owned(),
        least: all.iter().min_by(|a, b| a.1.total_cmp(&b.1))?.clone(),
        most: all.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.clone(),
    })
}

fn figure(summary: &SweepSummary) -> Option<Figure<'_>> {
    let fields = fields(summary);
    if fields.len() < MANY {
        return None;
    }
    let mut groups: Vec<(String, Vec<&SweepPoint>)> = Vec::new();
    for point in &summary.points {
        let name = format!("{}, {}", point.machine, point.policy);
        match groups.iter_mut().find(|(other, _)| *other == name) {
            Some((_, points)) => points.push(point),
            None => groups.push((name, vec![point])),
        }
    }
    let of_points = |points: &[&SweepPoint]| -> Vec<Reach> {
        let mut all: Vec<Reach> = fields.iter().filter_map(|field| reach(summary, points, field)).collect();
        all.sort_by(|a, b| b.width().total_cmp(&a.width()));
        all
    };
    let groups: Vec<(String, Vec<Reach>)> =
        groups.into_iter().map(|(name, points)| (name, of_points(&points))).collect();
    let widest = groups.iter().flat_map(|(name, all)| all.first().map(|it| (name, it)));
    let (name, widest) = widest.max_by(|a, b| a.1.width().total_cmp(&b.1.width()))?;
    let title = format!(
        "{} moves cycles most, from {} to {} on {name}",
        widest.field,
        signed(widest.least.1),
        signed(widest.most.1)
    );
    let about =
        "Cycles with culling from a field's best value to its worst, against the machine as it is; where fields were \
                 varied together, means of all points with the value."
            .into();
    Some(reaches((title, about), "cycles", ("faster", "slower"), groups))
}
