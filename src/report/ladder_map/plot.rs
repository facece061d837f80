//! The failure map of the fidelity levels: one panel per figure and band of axes, one row per level, one column per
//! point.

use super::data::{Axis, Figure, LadderMap, Point, Row, grid};
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::palette::{Color, GREEN, INK, ORANGE, SKY, VERMILLION, YELLOW, pale};
use crate::report::draw::{Figure as Drawn, Plot};
use crate::report::format::percent;

/// Where columns begin, the gap between axes, and the least width of a column.
const COLUMNS: i32 = 128;
const GAP: i32 = 12;
const COLUMN: i32 = 36;
/// Height of a row, and of the part above a panel's rows.
const ROW: i32 = 22;
const HEAD: i32 = 60;

/// Upper limit of an error, its name and its colour.
const LOOKS: [(f64, &str, Color); 5] = [
    (0.01, "within 1 %", GREEN),
    (0.03, "3 %", SKY),
    (0.1, "10 %", YELLOW),
    (0.3, "30 %", ORANGE),
    (f64::INFINITY, "more", VERMILLION),
];

fn look(error: f64) -> Color {
    let (.., color) = LOOKS.into_iter().find(|&(most, ..)| error.abs() <= most).unwrap_or(LOOKS[LOOKS.len() - 1]);
    pale(color)
}

pub(super) const PLOT: Plot<LadderMap> = Plot { name: "ladder", section: (), figure: |map| Some(figure(map)) };

/// Names the levels whose worst errors of cycles are smallest and largest.
pub(super) fn finding(map: &LadderMap) -> String {
    let worst = |index: usize| {
        let points = map.axes.iter().flat_map(|axis| &axis.points);
        let errors = points.filter_map(|point| point.rows[index].errors[Figure::Cycles as usize]);
        errors.map(f64::abs).reduce(f64::max)
    };
    let all = map.rows.iter().enumerate().filter_map(|(index, name)| Some((name, worst(index)?)));
    match (all.clone().min_by(|a, b| a.1.total_cmp(&b.1)), all.max_by(|a, b| a.1.total_cmp(&b.1))) {
        (Some((best, least)), Some((other, most))) => {
            format!("{best} is at most {} off Event in cycles, {other} up to {}", percent(least), percent(most))
        }
        _ => "No level gives cycles".into(),
    }
}

fn figure(map: &LadderMap) -> Drawn<'_> {
    let panels: Vec<_> = Figure::ALL.into_iter().map(|figure| (figure, shown(map, figure))).collect();
    let height: i32 = panels.iter().map(|(_, rows)| HEAD + rows.len() as i32 * ROW).sum();
    Drawn {
        title: finding(map),
        about: "Share in % by which each level is off Event. In bold: an interval that did not hold the cycles in \
                more than one of the samples."
            .into(),
        key: LOOKS.map(|(_, name, color)| (name.to_owned(), pale(color))).into(),
        data: grid(map),
        narrow: true,
        height: Box::new(move |width| height * bands(map, width).len() as i32 + LINE),
        paint: Box::new(move |canvas| {
            let mut y = 0;
            for (figure, rows) in &panels {
                for band in &bands(map, canvas.width()) {
                    panel(canvas, (map, band), *figure, rows, y)?;
                    y += HEAD + rows.len() as i32 * ROW;
                }
            }
            Ok(())
        }),
    }
}

/// The rows that have a figure.
fn shown(map: &LadderMap, figure: Figure) -> Vec<usize> {
    let says = |row: &Row| row.errors[figure as usize].is_some();
    let points = || map.axes.iter().flat_map(|axis| &axis.points);
    (0..map.rows.len()).filter(|&index| points().any(|point| says(&point.rows[index]))).collect()
}

/// Points of an axis that stand side by side: all points, if there is room.
type Piece<'a> = (&'a Axis, &'a [Point]);

/// The width of a piece: that of its points or of the axis's name, whichever is larger.
fn piece_width((axis, points): Piece<'_>) -> i32 {
    (points.len() as i32 * COLUMN).max(Text::NOTE.width(&axis.name))
}

/// Distributes the axes over bands, each at most as wide as the sheet.
fn bands(map: &LadderMap, sheet: i32) -> Vec<Vec<Piece<'_>>> {
    let room = ((sheet - COLUMNS - LEFT) / COLUMN).max(1) as usize;
    let pieces = map.axes.iter().flat_map(|axis| axis.points.chunks(room).map(move |points| (axis, points)));
    let mut bands: Vec<Vec<Piece<'_>>> = Vec::new();
    let mut end = sheet;
    for piece in pieces {
        let width = piece_width(piece);
        match bands.last_mut().filter(|_| end + width + LEFT <= sheet) {
            Some(band) => band.push(piece),
            None => {
                bands.push(vec![piece]);
                end = COLUMNS;
            }
        }
        end += width + GAP;
    }
    bands
}

fn panel(
    canvas: &Canvas<'_>,
    (map, band): (&LadderMap, &[Piece<'_>]),
    figure: Figure,
    rows: &[usize],
    top: i32,
) -> Result<(), DrawError> {
    canvas.text(figure.name(), (LEFT, top + 14), Text::LABEL.bold())?;
    let first = top + HEAD - 6;
    for (line, &row) in (0..).zip(rows) {
        canvas.text(&map.rows[row], (LEFT, first + line * ROW + ROW / 2), Text::NOTE.colored(INK))?;
    }
    let mut x = COLUMNS;
    for &(axis, points) in band {
        let width = piece_width((axis, points)) / points.len().max(1) as i32;
        canvas.text(&axis.name, (x, top + 34), Text::NOTE.colored(INK))?;
        for point in points {
            canvas.text(&point.value, (x + width / 2, first - 7), Text::NOTE.centered())?;
            for (line, &row) in (0..).zip(rows) {
                let y = first + line * ROW;
                let Row { errors, covered } = point.rows[row];
                let Some(error) = errors[figure as usize] else { continue };
                canvas.rect((x, y), (x + width - 1, y + ROW - 1), look(error))?;
                let lies = covered.is_some_and(|covered| covered.held + 1 < covered.told) && figure == Figure::Cycles;
                let text = Text::NOTE.colored(INK).centered();
                let text = if lies { text.bold() } else { text };
                canvas.text(&short(error), (x + width / 2, y + ROW / 2), text)?;
            }
            x += width;
        }
        x += GAP;
    }
    Ok(())
}

/// A share in percent that fits a cell.
fn short(share: f64) -> String {
    match (share * 100.0).round() {
        0.0 => "0".into(),
        percent if percent > 999.0 => ">k".into(),
        percent => format!("{percent:.0}"),
    }
}
