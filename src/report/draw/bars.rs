//! Horizontal stacked bars in named groups.

use super::canvas::{Canvas, DrawError, LEFT, LINE, Text, is_narrow, tick_step};
use super::figure::{Figure, Key};
use super::palette::{Color, FAINT, GRID};
use crate::report::format::number;
use crate::report::grid::Grid;

/// A bar chart.
pub(crate) struct BarChart {
    /// What the data shows, in a sentence.
    pub title: String,
    /// How to read it.
    pub about: String,
    /// The meaning of colours; may be empty.
    pub key: Key,
    /// What the length of bars means, with its unit.
    pub axis: &'static str,
    /// The unit of values.
    pub unit: &'static str,
    /// The length at the right end of the axis.
    pub max: f64,
    /// Formats a length.
    pub tick: fn(f64) -> String,
    /// The bars, from the top.
    pub groups: Vec<Group>,
}

/// Bars that belong together.
pub(crate) struct Group {
    /// Their name.
    pub name: String,
    /// The value whose bar has length 1 on the axis.
    pub whole: f64,
    /// The bars, from the top.
    pub bars: Vec<Bar>,
}

/// A bar.
pub(crate) struct Bar {
    /// Its name within the group.
    pub name: String,
    /// Its segments, from the left.
    pub segments: Vec<Segment>,
    /// The text at its end.
    pub note: String,
}

/// A part of a bar.
pub(crate) struct Segment {
    /// Its name in the data.
    pub part: String,
    /// Its value.
    pub value: f64,
    /// The colour of its meaning.
    pub color: Color,
}

const BAR: i32 = 20;
const GAP: i32 = 14;
/// On a narrow sheet, the height of a bar's text and of the bar.
const NARROW_TEXT: i32 = 18;
const NARROW_BAR: i32 = 12;
const AXIS: i32 = 46;

impl BarChart {
    /// The chart as a figure.
    pub(crate) fn figure(self) -> Figure<'static> {
        let heights = self.groups.iter().map(|group| group.bars.len() as i32).collect::<Vec<_>>();
        let height = move |width| {
            let group = |bars: &i32| match is_narrow(width) {
                true => LINE + bars * (NARROW_TEXT + NARROW_BAR) + GAP,
                false => bars * BAR + GAP,
            };
            heights.iter().map(group).sum::<i32>() + AXIS
        };
        Figure {
            title: self.title.clone(),
            about: self.about.clone(),
            key: self.key.clone(),
            data: self.data(),
            narrow: true,
            height: Box::new(height),
            paint: Box::new(move |canvas| if canvas.is_narrow() { self.narrow(canvas) } else { self.wide(canvas) }),
        }
    }

    /// One row per bar, one column per part.
    fn data(&self) -> Grid {
        let bars = || self.groups.iter().flat_map(|group| group.bars.iter().map(move |bar| (group, bar)));
        let mut parts: Vec<&str> = Vec::new();
        for segment in bars().flat_map(|(_, bar)| &bar.segments) {
            if !parts.contains(&segment.part.as_str()) {
                parts.push(&segment.part);
            }
        }
        let value = |bar: &Bar, part: &str| {
            let segment = bar.segments.iter().find(|segment| segment.part == part);
            segment.map_or_else(String::new, |segment| number(segment.value))
        };
        let row = |(group, bar): (&Group, &Bar)| {
            let names = [group.name.clone(), bar.name.clone()];
            names.into_iter().chain(parts.iter().map(|part| value(bar, part))).collect()
        };
        let heads = parts.iter().map(|part| format!("{part}, {}", self.unit));
        let head = ["group", "bar"].map(String::from).into_iter().chain(heads).collect();
        Grid { head, names: 2, rows: bars().map(row).collect() }
    }

    fn ticks(&self, canvas: &Canvas<'_>, left: i32, right: i32, bottom: i32) -> Result<(), DrawError> {
        let step = tick_step(self.max, ((right - left) / 70).max(2) as u32);
        for tick in (0..).map(|tick| f64::from(tick) * step).take_while(|&tick| tick <= self.max * 1.000_001) {
            let x = self.at(tick, left, right);
            let text = (self.tick)(tick);
            canvas.line(vec![(x, 0), (x, bottom)], GRID, 1)?;
            let half = Text::NOTE.width(&text) / 2;
            canvas.text(&text, (x.min(canvas.width() - half).max(half), bottom + 12), Text::NOTE.centered())?;
        }
        canvas.text(self.axis, ((left + right) / 2, bottom + 32), Text::NOTE.centered())
    }

    fn at(&self, length: f64, left: i32, right: i32) -> i32 {
        left + (length / self.max * f64::from(right - left)).round() as i32
    }

    /// Draws a bar's segments; returns the column where they end. A value below zero has no segment.
    fn bar(
        &self,
        canvas: &Canvas<'_>,
        (group, bar): (&Group, &Bar),
        (left, right): (i32, i32),
        (top, bottom): (i32, i32),
    ) -> Result<i32, DrawError> {
        let mut length = 0.0;
        for segment in &bar.segments {
            let from = self.at(length, left, right);
            length += segment.value / group.whole;
            if segment.value > 0.0 {
                // A value above zero is at least one pixel wide, so that it is visible.
                let to = self.at(length, left, right).max(from + 1);
                canvas.rect((from, top), (to, bottom), segment.color)?;
            }
        }
        Ok(self.at(length.max(0.0), left, right))
    }

    fn wide(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let bars = || self.groups.iter().flat_map(|group| &group.bars);
        let widest = |texts: &mut dyn Iterator<Item = i32>| texts.max().unwrap_or(0);
        let group_width = widest(&mut self.groups.iter().map(|group| Text::LABEL.bold().width(&group.name)));
        let name_width = widest(&mut bars().map(|bar| Text::LABEL.width(&bar.name)));
        let note_width = widest(&mut bars().map(|bar| Text::LABEL.width(&bar.note)));
        let left = LEFT + group_width + 16 + name_width + 10;
        let right = (canvas.width() - LEFT - note_width - 10).max(left + 60);
        let bottom = self.groups.iter().map(|group| group.bars.len() as i32 * BAR + GAP).sum();
        self.ticks(canvas, left, right, bottom)?;
        let mut y = GAP / 2;
        for group in &self.groups {
            canvas.text(&group.name, (LEFT, y + BAR / 2), Text::LABEL.bold())?;
            for bar in &group.bars {
                canvas.text(&bar.name, (left - 10, y + BAR / 2), Text::LABEL.right())?;
                let end = self.bar(canvas, (group, bar), (left, right), (y + 2, y + BAR - 2))?;
                canvas.text_on_paper(&bar.note, (end + 8, y + BAR / 2), Text::LABEL)?;
                y += BAR;
            }
            y += GAP;
        }
        canvas.line(vec![(left, 0), (left, bottom)], FAINT, 1)
    }

    fn narrow(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let (left, right) = (LEFT, canvas.width() - LEFT);
        let height = |group: &Group| LINE + group.bars.len() as i32 * (NARROW_TEXT + NARROW_BAR) + GAP;
        let bottom = self.groups.iter().map(height).sum();
        self.ticks(canvas, left, right, bottom)?;
        let mut y = 0;
        for group in &self.groups {
            canvas.text_on_paper(&group.name, (left, y + LINE / 2), Text::LABEL.bold())?;
            y += LINE;
            for bar in &group.bars {
                let middle = y + NARROW_TEXT / 2;
                canvas.text_on_paper(&bar.name, (left, middle), Text::NOTE)?;
                canvas.text_on_paper(&bar.note, (right, middle), Text::NOTE.right())?;
                y += NARROW_TEXT;
                self.bar(canvas, (group, bar), (left, right), (y, y + NARROW_BAR - 2))?;
                y += NARROW_BAR;
            }
            y += GAP;
        }
        Ok(())
    }
}
