//! Horizontal stacked bars in named groups: the form of all plots of a machine.

use plotters::style::RGBColor;

use super::canvas::{DrawError, LEFT, LINE, TITLES, Text, WIDTH, legend_height, palette, svg, tick_step};

/// A chart.
pub(crate) struct BarChart {
    /// What is shown.
    pub title: String,
    /// How to read it.
    pub subtitle: String,
    /// The meaning of colours; may be empty.
    pub legend: Vec<(String, RGBColor)>,
    /// What the bars' length is, with its unit.
    pub axis: &'static str,
    /// The length at the right end.
    pub max: f64,
    /// A length as text.
    pub tick: fn(f64) -> String,
    /// The bars, from the top.
    pub groups: Vec<Group>,
}

/// Bars that belong together.
pub(crate) struct Group {
    /// Their name.
    pub name: String,
    /// From the top.
    pub bars: Vec<Bar>,
}

/// A bar.
pub(crate) struct Bar {
    /// Its name within the group.
    pub name: String,
    /// From the left.
    pub segments: Vec<Segment>,
    /// What stands at its end.
    pub note: String,
}

/// A part of a bar.
pub(crate) struct Segment {
    /// Its length, in the axis's unit.
    pub length: f64,
    /// What it stands for.
    pub color: RGBColor,
}

const BAR: i32 = 20;
const GAP: i32 = 14;

impl BarChart {
    /// The chart as an SVG file.
    pub(crate) fn draw(&self) -> Result<String, DrawError> {
        let bars = || self.groups.iter().flat_map(|group| &group.bars);
        let widest = |texts: &mut dyn Iterator<Item = i32>| texts.max().unwrap_or(0);
        let group_width = widest(&mut self.groups.iter().map(|group| Text::LABEL.bold().width(&group.name)));
        let name_width = widest(&mut bars().map(|bar| Text::LABEL.width(&bar.name)));
        let note_width = widest(&mut bars().map(|bar| Text::LABEL.width(&bar.note)));
        let left = LEFT + group_width + 16 + name_width + 10;
        let right = WIDTH - LEFT - note_width - 10;
        let rows: i32 = self.groups.iter().map(|group| group.bars.len() as i32 * BAR + GAP).sum();
        let top = TITLES + if self.legend.is_empty() { 0 } else { legend_height(&self.legend) };
        let bottom = top + rows;

        svg(bottom + 3 * LINE, |canvas| {
            let below = canvas.titles(&self.title, &self.subtitle)?;
            if !self.legend.is_empty() {
                canvas.legend(below, &self.legend)?;
            }
            let at = |length: f64| left + (length / self.max * f64::from(right - left)).round() as i32;
            let step = tick_step(self.max, ((right - left) / 70).max(2) as u32);
            for tick in (0..).map(|tick| f64::from(tick) * step).take_while(|&tick| tick <= self.max * 1.000_001) {
                canvas.line(vec![(at(tick), top), (at(tick), bottom)], palette::GRID, 1)?;
                canvas.text(&(self.tick)(tick), (at(tick), bottom + 12), Text::NOTE.centered())?;
            }
            canvas.text(self.axis, ((left + right) / 2, bottom + 34), Text::NOTE.centered())?;

            let mut y = top + GAP / 2;
            for group in &self.groups {
                canvas.text(&group.name, (LEFT, y + BAR / 2), Text::LABEL.bold())?;
                for bar in &group.bars {
                    canvas.text(&bar.name, (left - 10, y + BAR / 2), Text::LABEL.right())?;
                    let mut length = 0.0;
                    for segment in &bar.segments {
                        let from = at(length);
                        length += segment.length;
                        if segment.length > 0.0 {
                            // What is there is seen, however little it is.
                            let to = at(length).max(from + 1);
                            canvas.rect((from, y + 2), (to, y + BAR - 2), segment.color)?;
                        }
                    }
                    let x = at(length) + 8;
                    // No line of the grid crosses the note.
                    canvas.rect((x - 4, y), (x + Text::LABEL.width(&bar.note), y + BAR), palette::PAPER)?;
                    canvas.text(&bar.note, (x, y + BAR / 2), Text::LABEL)?;
                    y += BAR;
                }
                y += GAP;
            }
            canvas.line(vec![(left, top), (left, bottom)], palette::FAINT, 1)
        })
    }
}
