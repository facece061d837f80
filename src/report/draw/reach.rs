//! How far each of several fields moves a figure: a bar from the least to the largest change, by groups.

use super::changes::{Bar, Bars};
use super::figure::Figure;
use super::palette::{GREEN, VERMILLION};
use crate::report::format::{number, signed};
use crate::report::grid::Grid;

/// The effect of a field on a figure: the field's values with the least and the largest figure, as changes against a
/// reference.
pub(crate) struct Reach {
    /// The field.
    pub field: String,
    /// The value with the least figure, and the change.
    pub least: (String, f64),
    /// The value with the largest figure, and the change.
    pub most: (String, f64),
}

impl Reach {
    /// The distance from the least change to the largest; the reference, 0, is included.
    pub(crate) fn width(&self) -> f64 {
        self.most.1.max(0.0) - self.least.1.min(0.0)
    }
}

/// The bars of all groups; `figure` names the figure that changes.
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
    let groups = groups.iter().map(|(name, all)| (Some(name.clone()), all.iter().map(bar).collect())).collect();
    let bars = Bars { groups, colors: [GREEN, VERMILLION] };
    let height = bars.height();
    Figure {
        title,
        about,
        key: vec![(less.into(), GREEN), (more.into(), VERMILLION)],
        data,
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| bars.paint(canvas)),
    }
}

/// The bar of a field.
fn bar(it: &Reach) -> Bar {
    // A narrow sheet shows the last two words of a path.
    let short = it.field.rmatch_indices('.').nth(1).map_or(it.field.as_str(), |(at, _)| &it.field[at + 1..]);
    let changes = format!("{} {} \u{2026} {} {}", it.least.0, signed(it.least.1), it.most.0, signed(it.most.1));
    Bar {
        text: format!("{}: {changes}", it.field),
        short: format!("{short}: {changes}"),
        least: it.least.1,
        most: it.most.1,
    }
}
