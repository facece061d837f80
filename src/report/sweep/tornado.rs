//! The effect of each of several fields on cycles: a bar from the best to the worst value.

use super::data::{SweepPoint, SweepSummary};
use super::fields::{Field, fields, value};
use super::values::shown;
use crate::report::draw::reach::{Reach, reaches};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{percent, signed};

/// The least number of fields for this plot; fewer fields have curves or a map.
const MANY: usize = 3;

pub(super) const PLOT: Plot<SweepSummary> = Plot { name: "sensitivity", section: (), figure };

/// Mean cycles of the points with each value, over those of the baseline, or of all points if there is no baseline.
/// Also the sum of the half widths at the least and the largest value.
fn reach(summary: &SweepSummary, points: &[&SweepPoint], field: &Field<'_>) -> Option<(Reach, f64)> {
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
        // The errors of points with the same value may be alike, so a mean does not reduce them.
        let open = with.iter().filter_map(|point| point.half_width_to_file()).fold(0.0, f64::max);
        Some(((shown(field.path, wanted), cycles(&with)? / reference - 1.0), open))
    };
    let all: Vec<((String, f64), f64)> = field.values.iter().filter_map(of_value).collect();
    let (least, open_at_least) = all.iter().min_by(|a, b| a.0.1.total_cmp(&b.0.1))?.clone();
    let (most, open_at_most) = all.iter().max_by(|a, b| a.0.1.total_cmp(&b.0.1))?.clone();
    Some((Reach { field: field.path.to_owned(), least, most }, open_at_least + open_at_most))
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
    let of_points = |points: &[&SweepPoint]| -> Vec<(Reach, f64)> {
        let mut all: Vec<_> = fields.iter().filter_map(|field| reach(summary, points, field)).collect();
        all.sort_by(|(a, _), (b, _)| b.width().total_cmp(&a.width()));
        all
    };
    let groups: Vec<(String, Vec<(Reach, f64)>)> =
        groups.into_iter().map(|(name, points)| (name, of_points(&points))).collect();
    let all = || groups.iter().flat_map(|(name, all)| all.iter().map(move |(reach, open)| (name, reach, *open)));
    let open = all().map(|(.., open)| open).fold(0.0, f64::max);
    all().next()?;
    let beyond = all().filter(|(_, reach, open)| reach.width() > *open);
    let title = match beyond.max_by(|(_, a, _), (_, b, _)| a.width().total_cmp(&b.width())) {
        Some((name, Reach { field, least, most }, _)) => {
            format!("{field} moves cycles most, from {} to {} on {name}", signed(least.1), signed(most.1))
        }
        None if open > 0.0 => format!("No field moves cycles by more than intervals leave open, {}", percent(open)),
        None => "No field moves cycles".into(),
    };
    let about = format!(
        "Cycles with culling from a field's best value to its worst, against the machine as it is; where fields were \
         varied together, means of all points with the value.{}",
        if open > 0.0 { format!(" Of samples, up to {} of that may be chance.", percent(open)) } else { String::new() }
    );
    let groups = groups.into_iter().map(|(name, all)| (name, all.into_iter().map(|(reach, _)| reach).collect()));
    Some(reaches((title, about), "cycles", ("faster", "slower"), groups.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::sample::sweep;
    use crate::report::sweep::data::{Change, Own};

    /// The title if the second value of each of three fields takes `times` as many cycles as the first.
    fn title(times: f64, half_width: Option<f64>) -> String {
        let mut summary = sweep();
        let own = SweepPoint { changes: Vec::new(), effect: None, ..summary.points.remove(0) };
        let names = ["l2.bytes", "traversal.count", "shadow_cache.count"];
        let of = |field: &str, value: &str| (field.to_owned(), value.to_owned());
        summary.own = names
            .map(|name| of(name, "1"))
            .map(|(field, value)| Own { machine: own.machine.clone(), field, value })
            .into();
        let other = summary.points.remove(0);
        let changed = names.map(|name| of(name, "2")).map(|(field, value)| {
            let mut point = SweepPoint { changes: vec![Change { field, value }], ..other.clone() };
            point.split.cycles[2] = (own.split.cycles[2] as f64 * times) as u64;
            point.effect.as_mut().unwrap().half_widths = half_width.map(|half| [half; 2]);
            point
        });
        summary.points = [own].into_iter().chain(changed).collect();
        figure(&summary).unwrap().title
    }

    #[test]
    fn what_intervals_leave_open_moves_nothing() {
        assert!(title(1.01, Some(0.009)).contains(" moves cycles most, from 0.0 % to +1.0 % on "));
        let open = "No field moves cycles by more than intervals leave open, 1.1 %";
        assert_eq!(title(1.01, Some(0.011)), open);
        assert!(title(1.01, None).contains(" moves cycles most"));
        assert_eq!(title(1.0, None), "No field moves cycles");
    }
}
