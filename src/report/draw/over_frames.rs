//! Panels one above the other that share an axis of frame numbers.

use super::canvas::{Canvas, DrawError, LEFT, LINE, Text, WIDTH, palette, tick_step};

/// Where panels' data begins and ends.
const X: (i32, i32) = (78, WIDTH - 246);
/// Where labels of lines begin, right of the data.
pub(crate) const LABELS: i32 = X.1 + 12;
/// The usual height of a panel's data.
pub(crate) const DATA: i32 = 170;
/// The height of a label of two lines.
pub(crate) const LABEL: i32 = 2 * LINE;

/// The height of a panel whose data is `data` high, with its heading and what is below.
pub(crate) const fn panel_height(data: i32) -> i32 {
    data + 58
}

/// A panel's place and axes.
pub(crate) struct Panel<'a, 'b> {
    canvas: &'a Canvas<'b>,
    /// Height of the data's top.
    top: i32,
    /// Height of the data's bottom.
    bottom: i32,
    frames: (f64, f64),
    values: (f64, f64),
}

/// What a panel is of.
pub(crate) struct Axes<'a> {
    /// What is drawn.
    pub heading: &'a str,
    /// Numbers of the frames that share the axis, in order.
    pub frames: &'a [u32],
    /// Least and largest value; the first is 0 or less.
    pub values: (f64, f64),
    /// How high the data is, in pixels.
    pub height: i32,
    /// Least distance of two ticks.
    pub least_tick: f64,
    /// A value as text.
    pub tick: fn(f64) -> String,
}

impl<'a, 'b> Panel<'a, 'b> {
    /// Draws axes from height `top` on, for [`panel_height`] pixels.
    pub(crate) fn new(canvas: &'a Canvas<'b>, top: i32, axes: &Axes<'_>) -> Result<Self, DrawError> {
        let (low, high) = axes.values;
        let step = tick_step((high - low).max(axes.least_tick), 5).max(axes.least_tick);
        let first = axes.frames.first().copied().map_or(0.0, f64::from);
        let last = axes.frames.last().copied().map_or(0.0, f64::from);
        // Half a bar's room at both ends.
        let margin = spacing(axes.frames) * 0.6;
        let panel = Self {
            canvas,
            top: top + 30,
            bottom: top + 30 + axes.height,
            frames: (first - margin, last + margin),
            values: ((low / step).floor() * step, (high / step).ceil().max(1.0) * step),
        };
        canvas.text(axes.heading, (LEFT, top + 12), Text::LABEL.bold())?;
        let ticks = ((panel.values.1 - panel.values.0) / step).round() as i32;
        for value in (0..=ticks).map(|tick| panel.values.0 + f64::from(tick) * step) {
            let y = panel.y(value);
            canvas.line(vec![(X.0, y), (X.1, y)], palette::GRID, 1)?;
            canvas.text(&(axes.tick)(value), (X.0 - 8, y), Text::NOTE.right())?;
        }
        let step = tick_step((last - first).max(1.0), 12).max(1.0);
        let ticks = (first / step).ceil() as i64..=(last / step).floor() as i64;
        for frame in ticks.map(|tick| tick as f64 * step) {
            let x = panel.x(frame);
            canvas.line(vec![(x, panel.bottom), (x, panel.bottom + 4)], palette::FAINT, 1)?;
            canvas.text(&frame.to_string(), (x, panel.bottom + 15), Text::NOTE.centered())?;
        }
        let zero = panel.y(0.0);
        canvas.line(vec![(X.0, zero), (X.1, zero)], palette::FAINT, 1)?;
        Ok(panel)
    }

    /// The column of a frame.
    pub(crate) fn x(&self, frame: f64) -> i32 {
        let (first, last) = self.frames;
        X.0 + ((frame - first) / (last - first) * f64::from(X.1 - X.0)).round() as i32
    }

    /// The height of a value.
    pub(crate) fn y(&self, value: f64) -> i32 {
        let (low, high) = self.values;
        self.bottom - ((value - low) / (high - low) * f64::from(self.bottom - self.top)).round() as i32
    }

    /// Heights of two-line labels that belong to `values`, one beside each as far as there is room.
    pub(crate) fn labels(&self, values: impl Iterator<Item = f64>) -> Vec<i32> {
        apart(&values.map(|value| self.y(value)).collect::<Vec<_>>(), self.bottom - LINE / 2)
    }

    /// A dashed line over all frames.
    pub(crate) fn level(&self, value: f64, color: plotters::style::RGBColor) -> Result<(), DrawError> {
        self.canvas.dashes(X.0, X.1, self.y(value), color)
    }

    /// Half the width of a frame's bar.
    pub(crate) fn half_bar(&self, frames: &[u32]) -> i32 {
        let pixels = f64::from(X.1 - X.0) * spacing(frames) / (self.frames.1 - self.frames.0);
        ((pixels * 0.35) as i32).clamp(1, 24)
    }
}

/// The axis's name, below the last panel.
pub(crate) fn name_frames(canvas: &Canvas<'_>, top: i32) -> Result<(), DrawError> {
    canvas.text("frame number", ((X.0 + X.1) / 2, top + LINE / 2), Text::NOTE.centered())
}

/// The least distance of two frames; 1 if there are not two.
fn spacing(frames: &[u32]) -> f64 {
    frames.windows(2).map(|pair| f64::from(pair[0].abs_diff(pair[1]))).reduce(f64::min).unwrap_or(1.0)
}

/// Heights of labels that are wanted at `wanted`, in the same order: at least [`LABEL`] apart, and the lowest not below
/// `bottom`.
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
