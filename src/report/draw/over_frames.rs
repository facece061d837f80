//! Panels one above the other that share an axis of frame numbers.

use super::canvas::{Canvas, DrawError, LEFT, LINE, Text, is_narrow, tick_step};
use super::palette::{Color, FAINT, GRID};

/// The first and last column of a panel's data.
fn data_range(width: i32) -> (i32, i32) {
    if is_narrow(width) { (56, width - 10) } else { (70, width - 300) }
}

/// The height of a panel's data.
const DATA: i32 = 150;
/// The height of a label beside the data: two lines.
const LABEL: i32 = 2 * LINE;

/// The height of a panel with this many labels.
pub(crate) fn panel_height(width: i32, labels: usize) -> i32 {
    if is_narrow(width) { DATA + 58 + labels as i32 * LINE } else { DATA.max(labels as i32 * LABEL) + 58 }
}

/// A label beside or below a panel: a colour, a name and a note, and the value that it belongs to.
pub(crate) struct Label {
    /// The value at which the label should stand.
    pub value: f64,
    /// Its colour.
    pub color: Color,
    /// The subject.
    pub name: String,
    /// The text about the subject.
    pub note: String,
}

/// A panel's place and axes.
pub(crate) struct Panel<'a, 'b> {
    canvas: &'a Canvas<'b>,
    /// Heights of the data's top and bottom.
    top: i32,
    bottom: i32,
    x: (i32, i32),
    frames: (f64, f64),
    values: (f64, f64),
}

/// The content of a panel and its axes.
pub(crate) struct Axes<'a> {
    /// The panel's heading.
    pub heading: &'a str,
    /// Numbers of the frames that share the axis, in order.
    pub frames: &'a [u32],
    /// Least and largest value; the first is 0 or less.
    pub values: (f64, f64),
    /// Number of the panel's labels.
    pub labels: usize,
    /// Least distance between two ticks.
    pub least_tick: f64,
    /// Formats a value.
    pub tick: fn(f64) -> String,
}

impl<'a, 'b> Panel<'a, 'b> {
    /// Draws axes from height `top` on, [`panel_height`] pixels high. The attribute `data-frames` tells the page's
    /// script the columns of the frames.
    pub(crate) fn new(canvas: &'a Canvas<'b>, top: i32, axes: &Axes<'_>) -> Result<Self, DrawError> {
        let (low, high) = axes.values;
        let step = tick_step((high - low).max(axes.least_tick), 4).max(axes.least_tick);
        let first = axes.frames.first().copied().map_or(0.0, f64::from);
        let last = axes.frames.last().copied().map_or(0.0, f64::from);
        // Room for half a bar at both ends.
        let margin = spacing(axes.frames) * 0.6;
        let x = data_range(canvas.width());
        let data = if canvas.is_narrow() { DATA } else { panel_height(canvas.width(), axes.labels) - 58 };
        let panel = Self {
            canvas,
            top: top + 30,
            bottom: top + 30 + data,
            x,
            frames: (first - margin, last + margin),
            values: ((low / step).floor() * step, (high / step).ceil().max(1.0) * step),
        };
        canvas.attribute("data-frames", &format!("{} {} {} {}", panel.frames.0, panel.frames.1, x.0, x.1));
        canvas.text(axes.heading, (LEFT, top + 12), Text::LABEL.bold())?;
        let ticks = ((panel.values.1 - panel.values.0) / step).round() as i32;
        for value in (0..=ticks).map(|tick| panel.values.0 + f64::from(tick) * step) {
            let y = panel.y(value);
            canvas.line(vec![(x.0, y), (x.1, y)], GRID, 1)?;
            canvas.text(&(axes.tick)(value), (x.0 - 8, y), Text::NOTE.right())?;
        }
        let most = if canvas.is_narrow() { 6 } else { 12 };
        let few = || axes.frames.iter().map(|&frame| f64::from(frame)).collect();
        let round = || {
            let step = tick_step((last - first).max(1.0), most).max(1.0);
            let ticks = (first / step).ceil() as i64..=(last / step).floor() as i64;
            ticks.map(|tick| tick as f64 * step).collect()
        };
        let ticks: Vec<f64> = if axes.frames.len() <= most as usize { few() } else { round() };
        for frame in ticks {
            let x = panel.x(frame);
            canvas.line(vec![(x, panel.bottom), (x, panel.bottom + 4)], FAINT, 1)?;
            canvas.text(&frame.to_string(), (x, panel.bottom + 15), Text::NOTE.centered())?;
        }
        let zero = panel.y(0.0);
        canvas.line(vec![(x.0, zero), (x.1, zero)], FAINT, 1)?;
        Ok(panel)
    }

    /// The column of a frame.
    pub(crate) fn x(&self, frame: f64) -> i32 {
        let (first, last) = self.frames;
        self.x.0 + ((frame - first) / (last - first) * f64::from(self.x.1 - self.x.0)).round() as i32
    }

    /// The height of a value.
    pub(crate) fn y(&self, value: f64) -> i32 {
        let (low, high) = self.values;
        self.bottom - ((value - low) / (high - low) * f64::from(self.bottom - self.top)).round() as i32
    }

    /// A line with a dot at each value; a frame without a value interrupts it.
    pub(crate) fn curve(
        &self,
        values: impl Iterator<Item = (u32, Option<f64>)>,
        color: Color,
    ) -> Result<(), DrawError> {
        let place = |(frame, value): (u32, Option<f64>)| Some((self.x(frame.into()), self.y(value?)));
        for run in values.map(place).collect::<Vec<_>>().split(Option::is_none) {
            let points: Vec<(i32, i32)> = run.iter().flatten().copied().collect();
            points.iter().try_for_each(|&point| self.canvas.dot(point, 3, color))?;
            if points.len() > 1 {
                self.canvas.line(points, color, 2)?;
            }
        }
        Ok(())
    }

    /// Draws labels: on a wide sheet beside the data, as close to their values as there is room; on a narrow one,
    /// below the data.
    pub(crate) fn labels(&self, labels: &[Label]) -> Result<(), DrawError> {
        if self.canvas.is_narrow() {
            for (label, y) in labels.iter().zip((self.bottom + 36..).step_by(LINE as usize)) {
                self.canvas.dot((LEFT + 4, y), 4, label.color)?;
                let text = format!("{}: {}", label.name, label.note);
                self.canvas.text(&text, (LEFT + 14, y), Text::NOTE)?;
            }
            return Ok(());
        }
        let wanted: Vec<i32> = labels.iter().map(|label| self.y(label.value)).collect();
        for (label, y) in labels.iter().zip(apart(&wanted, self.bottom - LINE / 2)) {
            let x = self.x.1 + 16;
            self.canvas.dot((x + 4, y), 4, label.color)?;
            self.canvas.text(&label.name, (x + 14, y), Text::LABEL.bold())?;
            self.canvas.text(&label.note, (x + 14, y + 17), Text::NOTE)?;
        }
        Ok(())
    }

    /// A dashed line across all frames at a value.
    pub(crate) fn level(&self, value: f64, color: Color) -> Result<(), DrawError> {
        self.canvas.dashes(self.x.0, self.x.1, self.y(value), color)
    }

    /// Half the width of a frame's bar.
    pub(crate) fn half_bar(&self, frames: &[u32]) -> i32 {
        let pixels = f64::from(self.x.1 - self.x.0) * spacing(frames) / (self.frames.1 - self.frames.0);
        ((pixels * 0.35) as i32).clamp(1, 24)
    }
}

/// The axis's name, below the last panel.
pub(crate) fn name_frames(canvas: &Canvas<'_>, top: i32) -> Result<(), DrawError> {
    let (from, to) = data_range(canvas.width());
    canvas.text("frame number", ((from + to) / 2, top + LINE / 2), Text::NOTE.centered())
}

/// The least distance between two frames; 1 for fewer than two frames.
fn spacing(frames: &[u32]) -> f64 {
    frames.windows(2).map(|pair| f64::from(pair[0].abs_diff(pair[1]))).reduce(f64::min).unwrap_or(1.0)
}

/// Heights of labels, in the order of the heights `wanted`. Labels are at least [`LABEL`] apart, and the lowest is
/// not below `bottom`.
fn apart(wanted: &[i32], bottom: i32) -> Vec<i32> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by_key(|&index| wanted[index]);
    let mut heights = wanted.to_vec();
    let mut free = i32::MIN;
    for &index in &order {
        heights[index] = heights[index].max(free);
        free = heights[index] + LABEL;
    }
    let mut free = bottom;
    for &index in order.iter().rev() {
        heights[index] = heights[index].min(free);
        free = heights[index] - LABEL;
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_pushed_apart_and_kept_inside() {
        assert_eq!(apart(&[100, 10, 12], 200), [100, 10, 50]);
        assert_eq!(apart(&[195, 190, 20], 200), [200, 160, 20]);
        assert_eq!(apart(&[], 200), [0; 0]);
    }
}
