//! How far figures change from one report to the other: a bar a figure.

use super::data::{Diff, changes, signed, told};
use super::figures::Figure as Compared;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text, tick_step};
use crate::report::draw::palette::{FAINT, GRID, ORANGE, SKY};
use crate::report::draw::{Figure, Plot};
use crate::report::format::percent_tick;

pub(super) const PLOT: Plot<Diff> = Plot { name: "changes", section: (), figure };

/// Height of a bar with its name, and of the axis.
const BAR: i32 = 36;
const AXIS: i32 = 30;
/// More figures than these stand in the table alone: those that change least.
const MOST: usize = 30;

fn figure(diff: &Diff) -> Option<Figure<'_>> {
    let mut changes = changes(diff);
    let left_out = changes.len().saturating_sub(MOST);
    changes.truncate(MOST);
    let (first, change) = changes.first()?;
    let rest = if left_out > 0 { format!(" {left_out} smaller changes are in the table.") } else { String::new() };
    Some(Figure {
        title: told(first, *change),
        about: format!("Change of each figure from A to B, as a share of A's.{rest}"),
        key: vec![("less in B".into(), SKY), ("more in B".into(), ORANGE)],
        data: diff.figures_grid(),
        narrow: true,
        height: Box::new({
            let height = changes.len() as i32 * BAR + AXIS;
            move |_| height
        }),
        paint: Box::new(move |canvas| paint(canvas, &changes)),
    })
}

fn paint(canvas: &Canvas<'_>, changes: &[(&Compared, f64)]) -> Result<(), DrawError> {
    let all = || changes.iter().map(|(_, change)| *change);
    let (low, high) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let (left, right) = (LEFT + 30, canvas.width() - 30);
    let at = |share: f64| left + ((share - low) / (high - low) * f64::from(right - left)).round() as i32;
    let bottom = changes.len() as i32 * BAR;
    let step = tick_step(high - low, ((right - left) / 90).max(2) as u32);
    for tick in (low / step).ceil() as i32..=(high / step).floor() as i32 {
        let x = at(f64::from(tick) * step);
        canvas.line(vec![(x, 0), (x, bottom)], GRID, 1)?;
        canvas.text(&percent_tick(f64::from(tick) * step), (x, bottom + 14), Text::NOTE.centered())?;
    }
    canvas.line(vec![(at(0.0), 0), (at(0.0), bottom)], FAINT, 1)?;
    for ((figure, change), y) in changes.iter().zip((0..).step_by(BAR as usize)) {
        canvas.text_on_paper(&format!("{}: {}", figure.name(), signed(*change)), (LEFT, y + LINE / 2), Text::NOTE)?;
        let color = if *change < 0.0 { SKY } else { ORANGE };
        canvas.rect((at(change.min(0.0)), y + LINE), (at(change.max(0.0)), y + BAR - 6), color)?;
    }
    Ok(())
}
