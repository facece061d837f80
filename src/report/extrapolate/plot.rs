//! Scale models and their predictions over the cores of the models: one row of panels per machine, one panel per
//! figure.

use super::data::{Extrapolation, Extrapolations, Told, Unit};
use super::words::grid;
use crate::quantity::Bytes;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text, is_narrow, tick_step};
use crate::report::draw::marks::mark;
use crate::report::draw::palette::{BLUE, GRID, SKY, VERMILLION, pale};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{bytes, exact, joules, percent, tick};
use crate::report::grid::Grid;

/// Height of a panel's axes, of the parts above and below them, and of a machine's name.
const PANEL: i32 = 150;
const ABOVE: i32 = 34;
const BELOW: i32 = 34;
const NAME: i32 = 26;
/// Where the axes of a panel begin, the room to their right, and the room beside their first and last point.
const AXIS: i32 = 70;
const BEHIND: i32 = 14;
const BESIDE: i32 = 16;

pub(super) const PLOT: Plot<Extrapolations> =
    Plot { name: "models", section: (), figure: |found| Some(figure(&found.0)) };

/// The predicted cycles of the largest machine; for several machines with checks, the largest error of cycles.
pub(super) fn finding(found: &[Extrapolation]) -> String {
    let off = found.iter().filter_map(|it| it.errors()?[0]).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    if let (Some(off), true) = (off, found.len() > 1) {
        return format!("Predictions of cycles are at most {} off what Event says", percent(off.abs()));
    }
    let Some(largest) = found.iter().max_by_key(|it| it.cores) else { return "No machine".into() };
    let told = format!("{} would take {} cycles", largest.name(), exact(largest.predicted.cycles.value.round() as u64));
    let than =
        off.map(|off| format!(", {} {} than by Event", percent(off.abs()), if off < 0.0 { "fewer" } else { "more" }));
    told + &than.unwrap_or_default()
}

/// Formats a value of a unit.
fn shown(unit: Unit, value: f64) -> String {
    match unit {
        _ if value == 0.0 => "0".into(),
        Unit::Cycles => tick(value),
        Unit::Bytes => bytes(Bytes(value as u64)),
        Unit::Joules => joules(value),
    }
}

/// Number of panels side by side on a sheet of this width.
fn columns(width: i32) -> i32 {
    if is_narrow(width) { 1 } else { 4 }
}

fn figure(found: &[Extrapolation]) -> Figure<'_> {
    let rows = |found: &Extrapolation, width: i32| (found.told().len() as i32 + columns(width) - 1) / columns(width);
    let height = move |found: &Extrapolation, width: i32| NAME + rows(found, width) * (ABOVE + PANEL + BELOW);
    Figure {
        title: finding(found),
        about: "Each model counts as many times as its share of the machine asks for, so that it stands for all of \
                it. The law is the line through the two largest models, over the inverse of the cores: the large \
                machine is at the left. The pale bar reaches as far as other laws."
            .into(),
        key: vec![
            ("models, and the law".to_owned(), SKY),
            ("predicted".to_owned(), BLUE),
            ("by Event".to_owned(), VERMILLION),
        ],
        data: data(found),
        narrow: true,
        height: Box::new(move |width| found.iter().map(|it| height(it, width)).sum()),
        paint: Box::new(move |canvas| {
            let (width, columns) = (canvas.width(), columns(canvas.width()));
            let mut top = 0;
            for machine in found {
                canvas.text(&format!("{}, {}", machine.name(), machine.policy), (LEFT, top + LINE / 2), Text::TITLE)?;
                for (place, told) in (0..).zip(machine.told()) {
                    let left = place % columns * (width / columns);
                    let at = (left, top + NAME + place / columns * (ABOVE + PANEL + BELOW));
                    panel(canvas, machine.cores, &told, (at, width / columns))?;
                }
                top += height(machine, width);
            }
            Ok(())
        }),
    }
}

/// Draws the panel of a figure of a machine with `large` cores, from `left` and `top` on.
fn panel(
    canvas: &Canvas<'_>,
    large: u64,
    told: &Told,
    ((left, top), width): ((i32, i32), i32),
) -> Result<(), DrawError> {
    let Told { models, predicted, truth, unit, name, .. } = told;
    let (begin, end, top) = (left + AXIS, left + width - BEHIND, top + ABOVE);
    let bottom = top + PANEL;
    // The axis is 1 / cores; the large machine is at its start.
    let from_large = |cores: u64| 1.0 / cores as f64 - 1.0 / large as f64;
    let farthest = models.iter().map(|&(cores, _)| from_large(cores)).fold(0.0, f64::max);
    let room = f64::from(end - begin - 2 * BESIDE);
    let x = |cores: u64| begin + BESIDE + (from_large(cores) / farthest * room).round() as i32;
    let most = models.iter().map(|&(_, value)| value).chain([predicted.high]).chain(*truth).fold(0.0, f64::max);
    if most == 0.0 {
        return canvas.text(&format!("{name}: none"), (left + LEFT, top - 18), Text::LABEL.bold());
    }
    let y = |value: f64| bottom - (value / most * f64::from(PANEL)).round() as i32;
    canvas.text(name, (left + LEFT, top - 18), Text::LABEL.bold())?;
    let step = tick_step(most, 4);
    for line in 0..=(most / step) as i32 {
        let value = f64::from(line) * step;
        canvas.line(vec![(begin, y(value)), (end, y(value))], GRID, 1)?;
        canvas.text(&shown(*unit, value), (begin - 6, y(value)), Text::NOTE.right())?;
    }
    let at = (x(large), y(predicted.value));
    canvas.rect((at.0 - 4, y(predicted.high)), (at.0 + 4, y(predicted.low)), pale(BLUE))?;
    let second = models.iter().rev().nth(1).map(|&(cores, value)| (x(cores), y(value)));
    canvas.line([at].into_iter().chain(second).collect(), SKY, 2)?;
    for &(cores, value) in models {
        mark(canvas, 0, (x(cores), y(value)), SKY, true)?;
        canvas.text(&cores.to_string(), (x(cores), bottom + 14), Text::NOTE.centered())?;
    }
    canvas.text(&large.to_string(), (at.0, bottom + 14), Text::NOTE.centered())?;
    mark(canvas, 0, at, BLUE, true)?;
    truth.map_or(Ok(()), |truth| mark(canvas, 3, (at.0, y(truth)), VERMILLION, false))
}

/// The tables of all machines, one below the other.
fn data(found: &[Extrapolation]) -> Grid {
    let grids: Vec<Grid> = found.iter().map(grid).collect();
    let names = grids.first().map_or_else(Vec::new, |grid| grid.head[1..].to_vec());
    let rows = grids.into_iter().flat_map(|Grid { head, rows, .. }| {
        let machine = head[0].clone();
        rows.into_iter().map(move |row| [machine.clone()].into_iter().chain(row).collect())
    });
    Grid {
        head: ["machine, policy", "of"].map(String::from).into_iter().chain(names).collect(),
        names: 2,
        rows: rows.collect(),
    }
}
