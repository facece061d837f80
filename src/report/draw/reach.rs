//! How far each of many things moves a figure: a bar from the least to the most, by groups.

use super::changes::{Bar, Bars};
use super::figure::Figure;
use super::palette::{GREEN, VERMILLION};
use crate::report::format::{number, signed};
use crate::report::grid::Grid;

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
    // The last two words of a path tell it where there is no room for all.
    let short = it.field.rmatch_indices('.').nth(1).map_or(it.field.as_str(), |(at, _)| &it.field[at + 1..]);
    let changes = format!("{} {} \u{2026} {} {}", it.least.0, signed(it.least.1), it.most.0, signed(it.most.1));
    Bar {
        text: format!("{}: {changes}", it.field),
        short: format!("{short}: {changes}"),
        least: it.least.1,
        most: it.most.1,
    }
}
