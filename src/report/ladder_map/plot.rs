//! The failure map of the ladder: a panel a figure, a row a rung, a column a point.

use plotters::style::RGBColor;

use super::data::{Figure, LadderMap, Row};
use crate::report::draw::Plot;
use crate::report::draw::canvas::{
    Canvas, DrawError, LEFT, LINE, TITLES, Text, WIDTH, legend_height, pale, palette, svg,
};

/// Where columns begin, and the gap between axes.
const COLUMNS: i32 = 128;
const GAP: i32 = 8;
/// Height of a row, and of what stands above a panel's rows.
const ROW: i32 = 22;
const HEAD: i32 = 60;

/// What an error is at most, and how it looks.
const LOOKS: [(f64, &str, RGBColor); 5] = [
    (0.01, "within 1 %", palette::GREEN),
    (0.03, "3 %", palette::SKY),
    (0.1, "10 %", palette::YELLOW),
    (0.3, "30 %", palette::ORANGE),
    (f64::INFINITY, "more", palette::VERMILLION),
];

fn look(error: f64) -> RGBColor {
    let (.., color) = LOOKS.into_iter().find(|&(most, ..)| error.abs() <= most).unwrap_or(LOOKS[LOOKS.len() - 1]);
    pale(color)
}

pub(super) const PLOT: Plot<LadderMap> = Plot { name: "ladder", section: (), draw: |map| draw(map).map(Some) };

fn draw(map: &LadderMap) -> Result<String, DrawError> {
    let legend: Vec<_> = LOOKS.map(|(_, name, color)| (name.to_owned(), pale(color))).into();
    let top = TITLES + legend_height(&legend);
    let panels: Vec<_> = Figure::ALL.into_iter().map(|figure| (figure, shown(map, figure))).collect();
    let height: i32 = panels.iter().map(|(_, rows)| HEAD + rows.len() as i32 * ROW).sum();
    let points: usize = map.axes.iter().map(|axis| axis.points.len()).sum();
    let width = (WIDTH - COLUMNS - LEFT - GAP * map.axes.len() as i32) / points.max(1) as i32;
    svg(top + height + LINE, |canvas| {
        canvas.titles(
            "Where rungs break",
            "share in % by which each is off Event; in bold: an interval that did not hold the cycles in more than one of the samples",
        )?;
        canvas.legend(TITLES, &legend)?;
        let mut y = top;
        for (figure, rows) in &panels {
            panel(canvas, map, *figure, rows, y, width)?;
            y += HEAD + rows.len() as i32 * ROW;
        }
        Ok(())
    })
}

/// The rows that say something about a figure.
fn shown(map: &LadderMap, figure: Figure) -> Vec<usize> {
    let says = |row: &Row| row.errors[figure as usize].is_some();
    let points = || map.axes.iter().flat_map(|axis| &axis.points);
    (0..map.rows.len()).filter(|&index| points().any(|point| says(&point.rows[index]))).collect()
}

fn panel(
    canvas: &Canvas<'_>,
    map: &LadderMap,
    figure: Figure,
    rows: &[usize],
    top: i32,
    width: i32,
) -> Result<(), DrawError> {
    canvas.text(figure.name(), (LEFT, top + 14), Text::LABEL.bold())?;
    let first = top + HEAD - 6;
    for (line, &row) in (0..).zip(rows) {
        canvas.text(&map.rows[row], (LEFT, first + line * ROW + ROW / 2), Text::NOTE.colored(palette::INK))?;
    }
    let mut x = COLUMNS;
    for axis in &map.axes {
        canvas.text(&axis.name, (x, top + 34), Text::NOTE.colored(palette::INK))?;
        for point in &axis.points {
            canvas.text(&point.value, (x + width / 2, first - 7), Text::NOTE.centered())?;
            for (line, &row) in (0..).zip(rows) {
                let y = first + line * ROW;
                let Row { errors, covered } = point.rows[row];
                let Some(error) = errors[figure as usize] else { continue };
                canvas.rect((x, y), (x + width - 1, y + ROW - 1), look(error))?;
                let lies = covered.is_some_and(|covered| covered.held + 1 < covered.told) && figure == Figure::Cycles;
                let text = Text::NOTE.colored(palette::INK).centered();
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
