//! Changes as bars on both sides of a reference, in groups. The line above each bar describes it.

use super::canvas::{Canvas, DrawError, LEFT, LINE, Text, tick_step};
use super::palette::{Color, FAINT, GRID};
use crate::report::format::percent_tick;

/// Height of a bar with its line of text, and of the axis.
const BAR: i32 = 42;
const AXIS: i32 = 30;
/// Space below a group.
const GAP: i32 = 10;

/// A bar.
pub(crate) struct Bar {
    /// Its line of text on a wide sheet, and on a narrow one.
    pub text: String,
    pub short: String,
    /// The least and the largest change: the bar extends from one to the other.
    pub least: f64,
    pub most: f64,
}

/// Bars in groups; a group may have a name.
pub(crate) struct Bars {
    /// The groups.
    pub groups: Vec<(Option<String>, Vec<Bar>)>,
    /// Colours below and above the reference.
    pub colors: [Color; 2],
}

impl Bars {
    fn all(&self) -> impl Iterator<Item = &Bar> {
        self.groups.iter().flat_map(|(_, all)| all)
    }

    /// The height of all groups and the axis.
    pub(crate) fn height(&self) -> i32 {
        let names = self.groups.iter().filter(|(name, _)| name.is_some()).count() as i32;
        self.all().count() as i32 * BAR + names * LINE + self.groups.len() as i32 * GAP + AXIS
    }

    /// Draws all groups.
    ///
    /// # Errors
    /// The drawing fails.
    pub(crate) fn paint(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let low = self.all().map(|bar| bar.least).fold(-0.001, f64::min);
        let high = self.all().map(|bar| bar.most).fold(0.001, f64::max);
        let (left, right) = (LEFT + 30, canvas.width() - 30);
        let at = |share: f64| left + ((share - low) / (high - low) * f64::from(right - left)).round() as i32;
        let bottom = self.height() - AXIS;
        let step = tick_step(high - low, ((right - left) / 90).max(2) as u32);
        for tick in (low / step).ceil() as i32..=(high / step).floor() as i32 {
            let share = f64::from(tick) * step;
            canvas.line(vec![(at(share), 0), (at(share), bottom)], GRID, 1)?;
            canvas.text(&percent_tick(share), (at(share), bottom + 14), Text::NOTE.centered())?;
        }
        canvas.line(vec![(at(0.0), 0), (at(0.0), bottom)], FAINT, 1)?;
        let mut y = 0;
        for (name, bars) in &self.groups {
            if let Some(name) = name {
                canvas.text_on_paper(name, (LEFT, y + LINE / 2), Text::LABEL.bold())?;
                y += LINE;
            }
            for bar in bars {
                let text = if canvas.is_narrow() { &bar.short } else { &bar.text };
                canvas.text_on_paper(text, (LEFT, y + LINE / 2), Text::NOTE)?;
                let [below, above] = self.colors;
                let (top, end) = (y + LINE, y + BAR - 6);
                canvas.rect((at(bar.least.min(0.0)), top), (at(bar.most.min(0.0)), end), below)?;
                canvas.rect((at(bar.least.max(0.0)), top), (at(bar.most.max(0.0)), end), above)?;
                y += BAR;
            }
            y += GAP;
        }
        Ok(())
    }
}
