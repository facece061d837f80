//! Two fields that were varied together: one map per machine and policy, one cell per pair of values.

use super::data::{SweepPoint, SweepSummary};
use super::fields::{Field, fields, value};
use super::values::shown;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::palette::{Color, GREEN, GRID, VERMILLION, faded};
use crate::report::draw::{Figure, Plot};
use crate::report::format::number;
use crate::report::format::signed;
use crate::report::grid::Grid;

const ROW: i32 = 26;
const ABOVE: i32 = 2 * LINE + 12;
const COLUMNS: i32 = 84;

pub(super) const PLOT: Plot<SweepSummary> = Plot { name: "heat-map", section: (), figure };

/// A point's change of cycles by culling.
fn gain(point: &SweepPoint) -> f64 {
    point.split.cycles[2] as f64 / point.split.cycles[0].max(1) as f64 - 1.0
}

fn figure(summary: &SweepSummary) -> Option<Figure<'_>> {
    let [across, down]: [Field<'_>; 2] = fields(summary).try_into().ok()?;
    if summary.points.iter().all(|point| point.changes.len() < 2) {
        return None;
    }
    let mut maps: Vec<(String, Vec<&SweepPoint>)> = Vec::new();
    for point in &summary.points {
        let name = format!("{}, {}", point.machine, point.policy);
        match maps.iter_mut().find(|(other, _)| *other == name) {
            Some((_, points)) => points.push(point),
            None => maps.push((name, vec![point])),
        }
    }
    let best = summary.points.iter().min_by(|a, b| gain(a).total_cmp(&gain(b)))?;
    let row = |point: &SweepPoint| {
        let of = |field: &Field<'_>| value(summary, point, field.path).unwrap_or_default().to_owned();
        vec![point.machine.clone(), point.policy.clone(), of(&across), of(&down), number(gain(point))]
    };
    let data = Grid {
        head: ["machine", "policy", across.path, down.path, "change of cycles"].map(Into::into).to_vec(),
        names: 2,
        rows: summary.points.iter().map(row).collect(),
    };
    let height = maps.len() as i32 * (ABOVE + down.values.len() as i32 * ROW + LINE);
    Some(Figure {
        title: format!("Culling gains most with {}: {} cycles on {}", best.label(), signed(gain(best)), best.machine),
        about: format!(
            "Change of cycles by culling. Across: `{}`, down: `{}`. The stronger the colour, the larger the change; \
             green is faster.",
            across.path, down.path
        ),
        key: vec![("faster with culling".into(), GREEN), ("slower".into(), VERMILLION)],
        data,
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| {
            let most = summary.points.iter().map(|point| gain(point).abs()).fold(0.01, f64::max);
            let each = ABOVE + down.values.len() as i32 * ROW + LINE;
            for (index, (name, points)) in (0..).zip(&maps) {
                canvas.text(name, (LEFT, index * each + LINE / 2), Text::LABEL.bold())?;
                let cell = |column: &str, row: &str| {
                    let has = |point: &SweepPoint, field: &Field<'_>, wanted: &str| {
                        value(summary, point, field.path) == Some(wanted)
                    };
                    points.iter().find(|it| has(it, &across, column) && has(it, &down, row)).map(|it| gain(it))
                };
                map(canvas, (&across, &down), index * each + ABOVE, most, cell)?;
            }
            Ok(())
        }),
    })
}

fn map(
    canvas: &Canvas<'_>,
    (across, down): (&Field<'_>, &Field<'_>),
    top: i32,
    most: f64,
    cell: impl Fn(&str, &str) -> Option<f64>,
) -> Result<(), DrawError> {
    let width = ((canvas.width() - COLUMNS - LEFT) / across.values.len().max(1) as i32).min(120);
    for (column, value) in (0..).zip(&across.values) {
        let x = COLUMNS + column * width + width / 2;
        canvas.text(&shown(across.path, value), (x, top - LINE / 2), Text::NOTE.centered())?;
    }
    for (row, value) in (0..).zip(&down.values) {
        let y = top + row * ROW;
        canvas.text(&shown(down.path, value), (COLUMNS - 8, y + ROW / 2), Text::NOTE.right())?;
        for (column, other) in (0..).zip(&across.values) {
            let (left, found) = (COLUMNS + column * width, cell(other, value));
            let color = found.map_or(GRID, |gain| strength(gain, most));
            canvas.rect((left, y), (left + width - 2, y + ROW - 2), color)?;
            if let Some(gain) = found {
                let text = if width < 60 { format!("{:+.0}", gain * 100.0) } else { signed(gain) };
                canvas.text(&text, (left + width / 2, y + ROW / 2 - 1), Text::NOTE.centered())?;
            }
        }
    }
    Ok(())
}

/// A colour whose opacity grows with the change.
fn strength(gain: f64, most: f64) -> Color {
    let color = if gain < 0.0 { GREEN } else { VERMILLION };
    faded(color, 0.06 + 0.5 * gain.abs() / most)
}
