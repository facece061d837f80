//! How far each of many things moves a figure: a bar from the least to the most, by groups.

use super::canvas::{Canvas, DrawError, LEFT, LINE, Text, tick_step};
use super::figure::Figure;
use super::palette::{FAINT, GREEN, GRID, VERMILLION};
use crate::report::format::{number, percent, percent_tick};
use crate::report::grid::Grid;

const BAR: i32 = 42;
const AXIS: i32 = 30;

/// What a field does to a figure: the values with the least and the most of it, as changes against a reference.
pub(crate) struct Reach {
    /// The field.
    pub field: String,
    /// The value with the least, and the change.
    pub least: (String, f64),
    /// The value with the most.
    pub most: (String, f64),
}

impl Reach {
    /// From the least, or the reference, to the most.
    pub(crate) fn width(&self) -> f64 {
        self.most.1.max(0.0) - self.least.1.min(0.0)
    }
}

/// A change with its sign.
pub(crate) fn signed(share: f64) -> String {
    if share > 0.0 { format!("+{}", percent(share)) } else { percent(share) }
}

/// The bars of all groups; `figure` names what moves.
pub(crate) fn reaches<'a>(
    (title, about): (String, String),
    figure: &str,
    (less, more): (&str, &str),
    groups: Vec<(String, Vec<Reach>)>,
) -> Figure<'a> {
    let row = |name: &str, it: &Reach| {
        let [least, most] = [&it.least, &it.most].map(|(value, change)| [value.clone(), number(*change)]);
        [name.to_owned(), it.field.clone()].into_iter().chain(least).chain(most).collect()
    };
    let rows = groups.iter().flat_map(|(name, all)| all.iter().map(move |it| row(name, it)));
    let change = format!("change of {figure}");
    let head = ["machine, policy", "field", "least with", &change, "most with", &change];
    let data = Grid { head: head.map(Into::into).to_vec(), names: 2, rows: rows.collect() };
    let bars: usize = groups.iter().map(|(_, all)| all.len()).sum();
    let height = bars as i32 * BAR + groups.len() as i32 * (LINE + 10) + AXIS;
    Figure {
        title,
        about,
        key: vec![(less.into(), GREEN), (more.into(), VERMILLION)],
        data,
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| paint(canvas, &groups)),
    }
}

fn paint(canvas: &Canvas<'_>, groups: &[(String, Vec<Reach>)]) -> Result<(), DrawError> {
    let all = || groups.iter().flat_map(|(_, all)| all);
    let low = all().map(|it| it.least.1).fold(-0.001, f64::min);
    let high = all().map(|it| it.most.1).fold(0.001, f64::max);
    let (left, right) = (LEFT + 30, canvas.width() - 30);
    let at = |share: f64| left + ((share - low) / (high - low) * f64::from(right - left)).round() as i32;
    let bottom = all().count() as i32 * BAR + groups.len() as i32 * (LINE + 10);
    let step = tick_step(high - low, ((right - left) / 90).max(2) as u32);
    for tick in (low / step).ceil() as i32..=(high / step).floor() as i32 {
        let share = f64::from(tick) * step;
        canvas.line(vec![(at(share), 0), (at(share), bottom)], GRID, 1)?;
        canvas.text(&percent_tick(share), (at(share), bottom + 14), Text::NOTE.centered())?;
    }
    canvas.line(vec![(at(0.0), 0), (at(0.0), bottom)], FAINT, 1)?;
    let mut y = 0;
    for (name, reaches) in groups {
        canvas.text_on_paper(name, (LEFT, y + LINE / 2), Text::LABEL.bold())?;
        y += LINE;
        for it in reaches {
            // The last two words of a path tell it where there is no room for all.
            let short = it.field.rmatch_indices('.').nth(1).map_or(it.field.as_str(), |(at, _)| &it.field[at + 1..]);
            let text = format!(
                "{}: {} {} \u{2026} {} {}",
                if canvas.is_narrow() { short } else { &it.field },
                it.least.0,
                signed(it.least.1),
                it.most.0,
                signed(it.most.1)
            );
            canvas.text_on_paper(&text, (LEFT, y + LINE / 2), Text::NOTE)?;
            let (top, low) = (y + LINE, y + BAR - 6);
            canvas.rect((at(it.least.1.min(0.0)), top), (at(it.most.1.min(0.0)), low), GREEN)?;
            canvas.rect((at(it.least.1.max(0.0)), top), (at(it.most.1.max(0.0)), low), VERMILLION)?;
            y += BAR;
        }
        y += 10;
    }
    Ok(())
}
