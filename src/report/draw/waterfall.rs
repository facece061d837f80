//! A waterfall: steps from one amount to another; a step that lowers the amount goes to the left.

use super::canvas::{Canvas, DrawError, LEFT, LINE, Text, is_narrow, tick_step};
use super::figure::{Figure, Key, wrapped};
use super::palette::{Color, FAINT, GRID};
use crate::report::format::number;
use crate::report::grid::Grid;

/// A waterfall.
pub(crate) struct Waterfall {
    /// What the data shows, in a sentence.
    pub title: String,
    /// How to read it.
    pub about: String,
    /// The meaning of colours.
    pub key: Key,
    /// What is measured, with its unit.
    pub axis: &'static str,
    /// Formats an amount.
    pub tick: fn(f64) -> String,
    /// Series of steps from one amount to another, each with its name.
    pub ways: Vec<(String, Vec<Level>)>,
}

/// An amount or a step.
pub(crate) struct Level {
    /// Its name.
    pub name: &'static str,
    /// Where it starts and ends; a whole amount starts at 0.
    pub span: (f64, f64),
    /// Its colour.
    pub color: Color,
    /// The text beside it.
    pub note: String,
}

const BAR: i32 = 24;
const GAP: i32 = 12;
const NARROW_BAR: i32 = 34;
const AXIS: i32 = 46;

/// The height of a series with its name.
fn way_height(name: &str, bars: usize, width: i32) -> i32 {
    let bar = if is_narrow(width) { NARROW_BAR } else { BAR };
    wrapped(name, Text::LABEL.bold(), width - LEFT).len() as i32 * LINE + bars as i32 * bar + GAP
}

impl Waterfall {
    /// The waterfall as a figure.
    pub(crate) fn figure(self) -> Figure<'static> {
        let sizes: Vec<_> = self.ways.iter().map(|(name, levels)| (name.clone(), levels.len())).collect();
        let height = move |width| sizes.iter().map(|(name, bars)| way_height(name, *bars, width)).sum::<i32>() + AXIS;
        let of_way = |(name, levels): &(String, Vec<Level>)| -> Vec<Vec<String>> {
            let row = |it: &Level| vec![name.clone(), it.name.into(), number(it.span.0), number(it.span.1)];
            levels.iter().map(row).collect()
        };
        Figure {
            title: self.title.clone(),
            about: self.about.clone(),
            key: self.key.clone(),
            data: Grid {
                head: ["policy", "step", "from", "to"].map(Into::into).to_vec(),
                names: 2,
                rows: self.ways.iter().flat_map(of_way).collect(),
            },
            narrow: true,
            height: Box::new(height),
            paint: Box::new(move |canvas| self.paint(canvas)),
        }
    }

    fn paint(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let levels = || self.ways.iter().flat_map(|(_, levels)| levels);
        let ends = levels().flat_map(|level| [level.span.0, level.span.1]);
        let (least, most) = ends.fold((0.0, 0.0), |(low, high): (f64, f64), end| (low.min(end), high.max(end)));
        let narrow = canvas.is_narrow();
        let name_width = levels().map(|level| Text::LABEL.width(level.name)).max().unwrap_or(0);
        let note_width = levels().map(|level| Text::LABEL.width(&level.note)).max().unwrap_or(0);
        let (left, right) = if narrow {
            (LEFT, canvas.width() - LEFT)
        } else {
            (LEFT + name_width + 16, canvas.width() - LEFT - note_width - 14)
        };
        let at = |amount: f64| left + ((amount - least) / (most - least) * f64::from(right - left)).round() as i32;
        let bar = if narrow { NARROW_BAR } else { BAR };
        let heights = self.ways.iter().map(|(name, levels)| way_height(name, levels.len(), canvas.width()));
        let bottom = heights.sum::<i32>();
        let step = tick_step(most - least, ((right - left) / 80).max(2) as u32);
        let first = (least / step).ceil() as i32;
        for amount in (first..).map(|tick| f64::from(tick) * step).take_while(|&amount| amount <= most * 1.000_001) {
            let text = (self.tick)(amount);
            let half = Text::NOTE.width(&text) / 2;
            canvas.line(vec![(at(amount), 0), (at(amount), bottom)], GRID, 1)?;
            let x = at(amount).min(canvas.width() - half).max(half);
            canvas.text(&text, (x, bottom + 12), Text::NOTE.centered())?;
        }
        canvas.text(self.axis, ((left + right) / 2, bottom + 32), Text::NOTE.centered())?;
        canvas.line(vec![(at(0.0), 0), (at(0.0), bottom)], FAINT, 1)?;
        let mut y = 0;
        for (name, levels) in &self.ways {
            for line in wrapped(name, Text::LABEL.bold(), canvas.width() - LEFT) {
                canvas.text_on_paper(&line, (LEFT, y + LINE / 2), Text::LABEL.bold())?;
                y += LINE;
            }
            let mut before: Option<(i32, i32)> = None;
            for level in levels {
                let (from, to) = (at(level.span.0.min(level.span.1)), at(level.span.0.max(level.span.1)));
                let (top, low) = if narrow { (y + LINE - 2, y + bar - 2) } else { (y + 3, y + bar - 3) };
                canvas.rect((from, top), (to.max(from + 1), low), level.color)?;
                if let Some((x, above)) = before {
                    canvas.line(vec![(x, above), (x, low)], FAINT, 1)?;
                }
                before = Some((at(level.span.1), low));
                if narrow {
                    canvas.text_on_paper(level.name, (LEFT, y + LINE / 2 - 2), Text::NOTE)?;
                    canvas.text_on_paper(&level.note, (right, y + LINE / 2 - 2), Text::NOTE.right())?;
                } else {
                    canvas.text(level.name, (left - 10, y + bar / 2), Text::LABEL.right())?;
                    canvas.text_on_paper(&level.note, (to.max(from + 1) + 8, y + bar / 2), Text::LABEL)?;
                }
                y += bar;
            }
            y += GAP;
        }
        Ok(())
    }
}
