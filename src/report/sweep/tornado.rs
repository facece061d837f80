//! How far each of many fields moves cycles: a bar from its best to its worst value.

use super::curves::signed;
use super::data::{SweepPoint, SweepSummary};
use super::fields::{Field, fields, value};
use super::values::shown;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text, tick_step};
use crate::report::draw::palette::{FAINT, GREEN, GRID, VERMILLION};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{number, percent_tick};
use crate::report::grid::Grid;

const BAR: i32 = 42;
const AXIS: i32 = 30;
/// Fewer fields are told by curves or a map.
const MANY: usize = 3;

pub(super) const PLOT: Plot<SweepSummary> = Plot { name: "sensitivity", section: (), figure };

/// What a field does to a machine under a policy: the values with the fewest and the most cycles, against the
/// reference.
struct Reach {
    field: String,
    least: (String, f64),
    most: (String, f64),
}

impl Reach {
    fn width(&self) -> f64 {
        self.most.1.max(0.0) - self.least.1.min(0.0)
    }
}

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
    let reaches = |points: &[&SweepPoint]| -> Vec<Reach> {
        let mut all: Vec<Reach> = fields.iter().filter_map(|field| reach(summary, points, field)).collect();
        all.sort_by(|a, b| b.width().total_cmp(&a.width()));
        all
    };
    let groups: Vec<(String, Vec<Reach>)> = groups.into_iter().map(|(name, points)| (name, reaches(&points))).collect();
    let widest = groups.iter().flat_map(|(name, all)| all.first().map(|it| (name, it)));
    let (name, widest) = widest.max_by(|a, b| a.1.width().total_cmp(&b.1.width()))?;
    let row = |name: &str, it: &Reach| {
        vec![
            name.to_owned(),
            it.field.clone(),
            it.least.0.clone(),
            number(it.least.1),
            it.most.0.clone(),
            number(it.most.1),
        ]
    };
    let rows = groups.iter().flat_map(|(name, all)| all.iter().map(move |it| row(name, it)));
    let data = Grid {
        head: ["machine, policy", "field", "best", "change of cycles", "worst", "change of cycles"]
            .map(Into::into)
            .to_vec(),
        names: 2,
        rows: rows.collect(),
    };
    let bars: usize = groups.iter().map(|(_, all)| all.len()).sum();
    let height = bars as i32 * BAR + groups.len() as i32 * (LINE + 10) + AXIS;
    Some(Figure {
        title: format!(
            "{} moves cycles most, from {} to {} on {name}",
            widest.field,
            signed(widest.least.1),
            signed(widest.most.1)
        ),
        about: "Cycles with culling from a field's best value to its worst, against the machine as it is; where fields were \
                varied together, means of all points with the value."
            .into(),
        key: vec![("faster".into(), GREEN), ("slower".into(), VERMILLION)],
        data,
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| paint(canvas, &groups)),
    })
}

fn paint(canvas: &Canvas<'_>, groups: &[(String, Vec<Reach>)]) -> Result<(), DrawError> {
    let all = || groups.iter().flat_map(|(_, all)| all);
    let low = all().map(|it| it.least.1).fold(-0.001, f64::min);
    let high = all().map(|it| it.most.1).fold(0.001, f64::max);
    let (left, right) = (LEFT + 30, canvas.width() - 30);
    let at = |share: f64| left + ((share - low) / (high - low) * f64::from(right - left)).round() as i32;
    let bottom = all().count() as i32 * BAR + groups.len() as i32 * (LINE + 10);
    let step = tick_step(high - low, ((right - left) / 90).max(2) as u32);
    for tick in (low / step).ceil() as i32..=(high / step).floor() as i32 {
        let share = f64::from(tick) * step;
        canvas.line(vec![(at(share), 0), (at(share), bottom)], GRID, 1)?;
        canvas.text(&percent_tick(share), (at(share), bottom + 14), Text::NOTE.centered())?;
    }
    canvas.line(vec![(at(0.0), 0), (at(0.0), bottom)], FAINT, 1)?;
    let mut y = 0;
    for (name, reaches) in groups {
        canvas.text_on_paper(name, (LEFT, y + LINE / 2), Text::LABEL.bold())?;
        y += LINE;
        for it in reaches {
            let text = format!(
                "{}: {} {} \u{2026} {} {}",
                it.field,
                it.least.0,
                signed(it.least.1),
                it.most.0,
                signed(it.most.1)
            );
            canvas.text_on_paper(&text, (LEFT, y + LINE / 2), Text::NOTE)?;
            let (top, low) = (y + LINE, y + BAR - 6);
            canvas.rect((at(it.least.1.min(0.0)), top), (at(it.most.1.min(0.0)), low), GREEN)?;
            canvas.rect((at(it.least.1.max(0.0)), top), (at(it.most.1.max(0.0)), low), VERMILLION)?;
            y += BAR;
        }
        y += 10;
    }
    Ok(())
}
